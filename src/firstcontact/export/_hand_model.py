"""``--to hand``: model folder for a hand that predicts by itself.

The export is an ordinary model folder. ``flash-model`` makes the image from it, and the host uses
it to check the hand's predictions.
"""

from __future__ import annotations

from pathlib import Path

from firstcontact.core import Calibration, InputError
from firstcontact.export._exporters import ModelExporter, Part
from firstcontact.export._model_image import ModelImage, model_image
from firstcontact.export._trained import Trained
from firstcontact.models import Model, NetworkPredictor, load_model


def write(trained: Trained, out: Path) -> list[str]:
    """Write detector and compact network. Raise InputError if the hand lacks kernels for them."""
    if trained.detector is None or trained.anytime is None:
        raise InputError(
            "a model for a hand needs a detector and a network, and this model lacks one of "
            "them: name a folder that `firstcontact adapt` wrote"
        )
    model_image(trained.detector, trained.anytime, None)  # refused before anything is written
    Model(trained.detector, (NetworkPredictor(trained.anytime),)).write(out)
    image = hand_image(out)
    return [
        f"model {image.digest}: {len(image.data)} bytes on the hand, without its rig's noise floors"
    ]


def hand_image(folder: Path, calibration: Calibration | None = None) -> ModelImage:
    """Return the image of a model folder for a hand, with the noise floors in ``calibration``.

    Raises
    ------
    InputError
        The folder holds no model for a hand, or is damaged.
    """
    model = load_model(folder)
    if model.network is None:
        raise InputError(
            f"{folder}: the folder has no network: write one with `firstcontact export-model "
            "MODEL --to hand --data RECORDINGS`"
        )
    try:
        return model_image(model.own_detector, model.network.model, calibration)
    except InputError as error:
        raise InputError(f"{folder}: {error}") from None


HAND = ModelExporter("hand", write, frozenset({Part.ANYTIME}))
