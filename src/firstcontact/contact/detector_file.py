"""Detectors on disk: a JSON card, and a safetensors file for trained detectors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from firstcontact.contact.detector import Detector
from firstcontact.contact.registry import DETECTORS, untrained_detector
from firstcontact.core import InputError, Layout, ModelError
from firstcontact.core.files import AnyPath
from firstcontact.core.records import Name
from firstcontact.core.weights import (
    DETECTOR_CARD,
    Rate,
    Sha256,
    digest,
    read_card,
    read_weights,
    write_weights,
)

DETECTOR_FORMAT = "firstcontact-detector"
#: Version of the format. It increases when older files can no longer be read.
FORMAT_VERSION = 1
CARD = DETECTOR_CARD
DETECTOR_WEIGHTS = "detector.safetensors"


@dataclass(frozen=True, slots=True)
class DetectorCard:
    """Card of a detector (``detector.json``): name, sampling rate, and hash of its arrays."""

    name: Name
    rate_hz: Rate | None = None
    sha256: Sha256 | None = None


def save_detector(
    detector: Detector, directory: AnyPath, data: Mapping[str, Any] | None = None
) -> Path:
    """Save a contact detector in a folder, such as that of a model. Return the folder.

    The folder is created if necessary, and a detector in it is replaced. ``data`` is a description
    of the training data, which is stored in ``detector.json``. Raise InputError if the detector
    must be trained first.
    """
    directory = Path(directory)
    arrays = detector.to_arrays()
    tree = {
        "format": DETECTOR_FORMAT,
        "format_version": FORMAT_VERSION,
        "name": detector.name,
        "rate_hz": detector.rate,
        "data": dict(data or {}),
    }
    write_weights(directory / CARD, directory / DETECTOR_WEIGHTS, tree, arrays, DetectorCard)
    return directory


def card_digest(directory: Path) -> str:
    """Return the hash of the detector's card in a folder, which the model's card stores."""
    return digest((directory / CARD).read_bytes())


def pretrained_detector() -> Detector:
    """Return the package's detector, which was trained on simulated data only."""
    return load_detector(Path(str(files("firstcontact.contact"))) / "pretrained")


def general_detector(layout: Layout) -> Detector:
    """Return a contact detector for this layout that needs no recordings of the hand itself.

    It is the package's trained detector if all sensors are on fingers and the sampling rate is that
    of its training. Otherwise it is a detector that needs no training.
    """
    shipped = pretrained_detector()
    # A trained detector accepts its own rate only, without tolerance for the error of a clock.
    if layout.rate == shipped.rate and None not in layout.vibration_fingers:
        return shipped
    return untrained_detector(layout)


def is_pretrained(detector: Detector) -> bool:
    """Return True if this is the detector in the package, unchanged."""
    shipped = pretrained_detector()
    if (detector.name, detector.rate) != (shipped.name, shipped.rate):
        return False
    arrays, expected = detector.to_arrays(), shipped.to_arrays()
    return arrays.keys() == expected.keys() and all(
        np.array_equal(arrays[k], expected[k]) for k in expected
    )


def load_detector(path: AnyPath) -> Detector:
    """Load a contact detector from its folder, or from the file ``detector.json`` in it.

    No code in the files runs. Raise InputError if a file is missing, damaged, or from another
    program or version.
    """
    path = Path(path)
    folder = path.parent if path.is_file() else path
    file = folder / CARD
    card = read_card(file, "detector", DETECTOR_FORMAT, FORMAT_VERSION, DetectorCard)
    if card.name not in DETECTORS:
        raise ModelError(
            f"{file} needs the detector {card.name!r}, but there are only "
            f"{', '.join(DETECTORS.names)}: update firstcontact or train again"
        )
    kind = DETECTORS[card.name]
    if card.sha256 is not None:
        arrays = read_weights(folder / DETECTOR_WEIGHTS, card.sha256, CARD)
    elif kind.learns:
        raise ModelError(f"{file} lacks the field 'sha256': train again")
    else:
        arrays = {}
    try:
        with np.errstate(all="ignore"):  # the decision refuses values that overflow
            detector = kind.from_arrays(arrays)
    except InputError as error:
        raise ModelError(f"{folder / DETECTOR_WEIGHTS} cannot be used, because {error}") from None
    if card.rate_hz != detector.rate:
        raise ModelError(
            f"the field 'rate_hz' of {file} is {card.rate_hz!r}, but the detector in "
            f"{DETECTOR_WEIGHTS} was trained at {detector.rate!r}: train again"
        )
    return detector
