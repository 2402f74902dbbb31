"""What was learned, on disk: numbers in safetensors, and a JSON card that vouches for them.

No code is in either, and none is run.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Annotated, Any, TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from firstcontact.core._errors import InputError
from firstcontact.core._files import read_regular, replacing, write_text
from firstcontact.core._records import Name, read_record

T = TypeVar("T")

#: Card of the detector that goes with the models beside it or below it.
DETECTOR_CARD = "detector.json"
#: Longest card and largest weights file that are read, bytes. A card lists sessions and
#: specimens; an SVM of 100,000 support vectors has 30 MB.
LONGEST_CARD = 1 << 22
LONGEST_WEIGHTS = 1 << 28
#: Largest number of an array whose products are taken; float32 ends at 3.4e38.
LARGEST = 1e30
#: A digest as :func:`digest` gives it.
Sha256 = Annotated[str, msgspec.Meta(pattern="^[0-9a-f]{64}$")]
#: A sampling rate, Hz.
Rate = Annotated[float, msgspec.Meta(gt=0, le=1e7)]

_LIBRARIES = ("firstcontact", "numpy", "scikit-learn", "skops", "torch", "onnxruntime", "mapie")


@dataclass(frozen=True, slots=True)
class _Head:
    """What every card begins with."""

    format: Name
    format_version: int


def write_weights(
    card: Path,
    weights: Path,
    tree: Mapping[str, Any],
    arrays: Mapping[str, NDArray[Any]],
    kind: type[Any],
) -> None:
    """Write the weights, and last the card that vouches for them.

    Parameters
    ----------
    card, weights
        Files; replaced if they are there.
    tree
        The card's fields, ``format`` among them; ``versions`` of the libraries
        and ``sha256`` of the weights are added.
    arrays
        By name; where there are none no weights are written, and old ones go.
    kind
        The record that the card will be read as.

    Raises
    ------
    InputError
        More than could be read again, or a field that could not, before any
        file is touched.
    ValueError
        A card that JSON cannot hold, likewise.
    """
    from safetensors.numpy import save

    # Not ascontiguousarray, which gives a number an axis.
    whole = {name: np.asarray(a, order="C") for name, a in arrays.items()}
    raw = save(whole, metadata={"format": tree["format"]}) if whole else None
    full = {
        **tree,
        "versions": _versions(),
        "sha256": None if raw is None else digest(raw),
    }
    text = json.dumps(full, indent=2, allow_nan=False) + "\n"
    read_record(text.encode(), kind, f"{card} that is to be written", "rename it", LONGEST_CARD)
    if len(raw or b"") > LONGEST_WEIGHTS:
        raise InputError(
            f"{weights} would have {len(raw or b'')} bytes, more than {LONGEST_WEIGHTS}: train "
            "on fewer pinches"
        )
    if raw is not None:
        with replacing(weights) as temporary:
            temporary.write_bytes(raw)
    write_text(card, text)
    if raw is None:
        weights.unlink(missing_ok=True)


def _versions() -> dict[str, str]:
    """Versions of what is installed of the libraries that train and run."""
    found = {}
    for name in _LIBRARIES:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def read_card(path: Path, what: str, form: str, form_version: int, kind: type[T]) -> T:
    """A card as a checked record, its ``format`` and ``format_version`` first.

    Parameters
    ----------
    path
        The card.
    what
        "model" or "detector", for messages.
    form, form_version
        What the two fields must be.
    kind
        The record.

    Raises
    ------
    InputError
        Missing, damaged, of something else or of another version, or with a
        field that cannot be what it says.
    """
    try:
        text = read_regular(path, LONGEST_CARD)
    except FileNotFoundError:
        raise InputError(
            f"{path}: there is no {what} here: name a folder that `firstcontact train` wrote"
        ) from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}): check the file") from None
    remedy = "train again or copy it again"
    head = read_record(text, _Head, str(path), remedy, LONGEST_CARD)
    if head.format != form:
        raise InputError(f"{path}: is not the card of a firstcontact {what} (field format)")
    if head.format_version != form_version:
        raise InputError(
            f"{path}: format_version is {head.format_version} but this program reads "
            f"{form_version}: update firstcontact, or train again"
        )
    return read_record(text, kind, str(path), remedy, LONGEST_CARD)


def read_verified(path: Path, sha256: str, card: str, most: int) -> bytes:
    """A file of at most so many bytes that its card vouches for.

    Parameters
    ----------
    path
        The file.
    sha256
        Of its bytes, as ``card`` (a name, for messages) says.
    most
        More bytes than this are not looked at.

    Raises
    ------
    InputError
        Missing, too long, or another file than the card means.
    """
    try:
        raw = read_regular(path, most)
    except OSError:
        raise InputError(f"{path}: cannot be read: copy the folder whole") from None
    if digest(raw) != sha256:
        raise InputError(
            f"{path}: its content does not match sha256 in {card}: "
            "the file is damaged or belongs to another card: copy the folder again"
        )
    return raw


def digest(data: bytes) -> str:
    """SHA-256 as cards hold it."""
    return hashlib.sha256(data).hexdigest()


def read_weights(path: Path, sha256: str, card: str) -> dict[str, NDArray[Any]]:
    """Arrays of a safetensors file that its card vouches for.

    Parameters
    ----------
    path
        The file.
    sha256
        Of its bytes, as ``card`` (a name, for messages) says.

    Raises
    ------
    InputError
        Missing, damaged, no safetensors file, or with values that are not
        finite.
    """
    from safetensors import SafetensorError
    from safetensors.numpy import load

    raw = read_verified(path, sha256, card, LONGEST_WEIGHTS)
    try:
        arrays = load(raw)
    except (SafetensorError, ValueError, KeyError, TypeError):
        raise InputError(f"{path}: is not a safetensors file: train again") from None
    for name, array in arrays.items():
        if array.dtype == np.uint8:  # bytes, which whoever wants them looks through
            continue
        if not np.issubdtype(array.dtype, np.floating) or not np.isfinite(array).all():
            raise InputError(f"{path}: the array {name} holds values that are not finite numbers")
    return arrays


def take_array(
    arrays: Mapping[str, NDArray[Any]], name: str, *shape: int | None
) -> NDArray[np.floating]:
    """Return an array of a file of weights, checked against its declared shape.

    Parameters
    ----------
    arrays
        Those of the file.
    name
        Which one.
    shape
        Its shape; None stands for any length.

    Raises
    ------
    InputError
        Names an array that is missing, has another shape, or holds anything but numbers up to
        ``LARGEST``.
    """
    if name not in arrays:
        raise InputError(f"the array {name} is missing")
    array = arrays[name]
    if len(array.shape) != len(shape) or any(
        wanted not in (None, size) for size, wanted in zip(array.shape, shape, strict=True)
    ):
        wanted = ", ".join("any" if size is None else str(size) for size in shape)
        raise InputError(f"the array {name} has the shape {array.shape} and must have ({wanted})")
    if (
        not np.issubdtype(array.dtype, np.floating)
        or not (np.abs(array.astype(np.float64)) <= LARGEST).all()
    ):
        raise InputError(f"the array {name} holds what is no number up to {LARGEST:g}")
    return array
