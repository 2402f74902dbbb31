"""``--to hand``: what a hand that answers by itself is flashed with, and the host checks it by.

The folder is one of models like any other: the image is made from it when it is flashed.
"""

from __future__ import annotations

from pathlib import Path

from firstcontact.core import Calibration, InputError
from firstcontact.export._exporters import ModelExporter, Part
from firstcontact.export._model_image import ModelImage, model_image
from firstcontact.export._trained import Trained
from firstcontact.models import Model, NetworkPredictor, load_model


def write(trained: Trained, out: Path) -> list[str]:
    """Write detector and compact model; InputError where the hand has no such kernels."""
    if trained.detector is None or trained.anytime is None:
        raise InputError(
            "a hand predicts with a detector and the network, and not both are here: name a "
            "folder that `firstcontact adapt` wrote"
        )
    model_image(trained.detector, trained.anytime, None)  # refused before anything is written
    Model(trained.detector, (NetworkPredictor(trained.anytime),)).write(out)
    image = hand_image(out)
    return [
        f"model {image.digest}: {len(image.data)} bytes on the hand, without its rig's noise floors"
    ]


def hand_image(folder: Path, calibration: Calibration | None = None) -> ModelImage:
    """Return the image of a model folder for a hand, with the noise floors of its rig.

    Raises
    ------
    InputError
        It is none, or damaged.
    """
    model = load_model(folder)
    if model.network is None:
        raise InputError(
            f"{folder}: no network is here: write one with `firstcontact export-model "
            "MODEL --to hand --data RECORDINGS`"
        )
    try:
        return model_image(model.own_detector, model.network.model, calibration)
    except InputError as error:
        raise InputError(f"{folder}: {error}") from None


HAND = ModelExporter("hand", write, frozenset({Part.ANYTIME}))
