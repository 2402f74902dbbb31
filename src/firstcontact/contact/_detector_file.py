"""Detectors on disk: a card in JSON, and the numbers of those that learn in safetensors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np

from firstcontact.contact._detector import Detector
from firstcontact.contact._registry import DETECTORS
from firstcontact.core import (
    DETECTOR_CARD,
    AnyPath,
    InputError,
    Name,
    Rate,
    Sha256,
    digest,
    read_card,
    read_weights,
    write_weights,
)

DETECTOR_FORMAT = "firstcontact-detector"
#: Raised whenever older files can no longer be read.
FORMAT_VERSION = 1
CARD = DETECTOR_CARD
DETECTOR_WEIGHTS = "detector.safetensors"


@dataclass(frozen=True, slots=True)
class DetectorCard:
    """What the card of a detector must hold.

    Parameters
    ----------
    name
        In the registry.
    rate_hz
        Of the samples it takes; None where it takes any.
    sigmas
        Height of the threshold, in the cards of older versions.
    sha256
        Of the weights, None where it has none.
    """

    name: Name
    rate_hz: Rate | None = None
    sigmas: Annotated[float, msgspec.Meta(gt=0, le=1e6)] | None = None
    sha256: Sha256 | None = None


def save_detector(
    detector: Detector, directory: AnyPath, data: Mapping[str, Any] | None = None
) -> Path:
    """Write a fitted detector into a folder, beside the models that go with it.

    Parameters
    ----------
    detector
        A registered one.
    directory
        Made if it does not exist; a detector in it is replaced.
    data
        What it learned from, for whoever reads the card.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    InputError
        A detector that has learned nothing yet.
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
    """What a model's card holds of the detector in a folder, so that no other is taken for it."""
    return digest((directory / CARD).read_bytes())


def pretrained_detector() -> Detector:
    """Load the detector that came with the package: it was trained on the twin alone.

    Raises
    ------
    InputError
        A package that is damaged.
    """
    return load_detector(Path(str(files("firstcontact.contact"))) / "pretrained")


def load_detector(path: AnyPath) -> Detector:
    """Read a detector. Nothing in its files is executed.

    Parameters
    ----------
    path
        The folder that it is in, or that of a model one below it, or the card there.

    Raises
    ------
    InputError
        A file that is missing, damaged, of another program or version, or
        whose numbers do not fit together.
    """
    path = Path(path)
    folder = path.parent if path.is_file() else path
    if not (folder / CARD).exists() and (folder.parent / CARD).exists():
        folder = folder.parent
    file = folder / CARD
    card = read_card(file, "detector", DETECTOR_FORMAT, FORMAT_VERSION, DetectorCard)
    if card.name not in DETECTORS:
        raise InputError(
            f"{file}: no detector is called {card.name!r} "
            f"(there are {', '.join(DETECTORS.names)}): update firstcontact or train again"
        )
    kind = DETECTORS[card.name]
    if card.sha256 is not None:
        arrays = read_weights(folder / DETECTOR_WEIGHTS, card.sha256, CARD)
    elif kind.learns:
        raise InputError(f"{file}: sha256 is missing: train again")
    else:  # nothing to keep, or of a version that kept this in the card
        arrays = {} if card.sigmas is None else {"sigmas": np.array(card.sigmas)}
    try:
        with np.errstate(all="ignore"):  # what overflows here is refused where it decides
            detector = kind.from_arrays(arrays)
    except InputError as error:
        raise InputError(f"{folder / DETECTOR_WEIGHTS}: {error}") from None
    if card.rate_hz != detector.rate:
        raise InputError(
            f"{file}: rate_hz is {card.rate_hz!r} but {DETECTOR_WEIGHTS} says {detector.rate!r}: "
            "train again"
        )
    return detector
