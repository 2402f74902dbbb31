"""``--to hand``: what a hand that answers by itself is flashed with, and the host checks it by.

The folder is one of models like any other: the image is made from it when it is flashed.
"""

from __future__ import annotations

from pathlib import Path

from firstcontact.contact import load_detector, save_detector
from firstcontact.core import Calibration, InputError
from firstcontact.export._exporters import ModelExporter, Part
from firstcontact.export._model_image import ModelImage, model_image
from firstcontact.export._trained import Trained
from firstcontact.models import has_anytime, load_anytime, save_anytime


def write(trained: Trained, out: Path) -> list[str]:
    """Write detector and compact model; InputError where the hand has no such kernels."""
    if trained.detector is None or trained.anytime is None:
        raise InputError(
            "a hand answers with a detector and an any-time model, and not both are here: name a "
            "folder that `firstcontact adapt` wrote"
        )
    model_image(trained.detector, trained.anytime, None)  # refused before anything is written
    save_detector(trained.detector, out)
    save_anytime(trained.anytime, out, {})
    image = hand_image(out)
    return [
        f"model {image.digest}: {len(image.data)} bytes on the hand, without its rig's noise floors"
    ]


def hand_image(folder: Path, calibration: Calibration | None = None) -> ModelImage:
    """What goes to a hand from such a folder, with the noise floors of its rig.

    Raises
    ------
    InputError
        It is none, or damaged.
    """
    if not has_anytime(folder):
        raise InputError(
            f"{folder}: no any-time model is here: write one with `firstcontact export-model "
            "MODEL --to hand --data RECORDINGS`"
        )
    try:
        return model_image(load_detector(folder), load_anytime(folder), calibration)
    except InputError as error:
        raise InputError(f"{folder}: {error}") from None


HAND = ModelExporter("hand", write, frozenset({Part.ANYTIME}))
