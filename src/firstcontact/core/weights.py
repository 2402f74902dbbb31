"""Trained weights as files: arrays in safetensors, and a JSON card with their checksum.

Neither file contains code, and reading them runs none.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from firstcontact.core._errors import ModelError
from firstcontact.core.files import read_regular, replacing, write_text
from firstcontact.core.installation import installed_versions
from firstcontact.core.records import Name, read_record

T = TypeVar("T")

#: File name of a detector's card. Models in the same folder and in folders below it use this
#: detector.
DETECTOR_CARD = "detector.json"
#: Longest card and largest weights file that are read, bytes. A card lists sessions and
#: specimens; an SVM of 100,000 support vectors has 30 MB.
LONGEST_CARD = 1 << 22
LONGEST_WEIGHTS = 1 << 28
#: Largest array value that enters products; float32 ends at 3.4e38.
LARGEST = 1e30
#: SHA-256 digest, as :func:`digest` returns it.
Sha256 = Annotated[str, msgspec.Meta(pattern="^[0-9a-f]{64}$")]
#: Sampling rate of a model or detector, Hz. At the lowest rate a step of 3 ms still holds a sample.
Rate = Annotated[float, msgspec.Meta(ge=500.0, le=1e7)]


@dataclass(frozen=True, slots=True)
class _Head:
    """Name and version of the format of a model's card. Every card begins with these fields."""

    format: Name
    format_version: int


def write_weights(
    card: Path,
    weights: Path,
    tree: Mapping[str, Any],
    arrays: Mapping[str, NDArray[Any]],
    kind: type[Any],
) -> None:
    """Write arrays to the file ``weights``, then the JSON file ``card`` with their checksum.

    ``tree`` holds the fields of the card, to which versions and checksum are added. ``kind`` is the
    type that the card must fit. Without arrays, an existing weights file is removed.
    """
    from safetensors.numpy import save

    # ascontiguousarray would turn a scalar into an array with one axis.
    contiguous = {name: np.asarray(a, order="C") for name, a in arrays.items()}
    raw = save(contiguous, metadata={"format": tree["format"]}) if contiguous else None
    full = {
        **tree,
        "versions": installed_versions(),
        "sha256": None if raw is None else digest(raw),
    }
    text = json.dumps(full, indent=2, allow_nan=False) + "\n"
    read_record(text.encode(), kind, f"{card} (not yet written)", "rename it", LONGEST_CARD)
    if raw is not None:
        with replacing(weights) as temporary:
            temporary.write_bytes(raw)
    write_text(card, text)
    if raw is None:
        weights.unlink(missing_ok=True)


def read_card(
    path: Path, noun: str, expected_format: str, expected_version: int, kind: type[T]
) -> T:
    """Read the JSON card of trained weights as a value of the type ``kind``.

    Raises ModelError, with ``noun`` for the model, if the card cannot be read or has another format
    or version.
    """
    try:
        text = read_regular(path, LONGEST_CARD)
    except FileNotFoundError:
        raise ModelError(
            f"there is no {noun} at {path}: choose a folder that `firstcontact train` wrote"
        ) from None
    except OSError as error:
        raise ModelError(f"{path} cannot be read ({error.strerror}): check the file") from None
    remedy = "train again or copy it again"
    head = read_record(text, _Head, str(path), remedy, LONGEST_CARD, ModelError)
    if head.format != expected_format:
        raise ModelError(
            f"{path}: the field 'format' is {head.format!r}, not {expected_format!r}: choose the "
            f"folder of a {noun}"
        )
    if head.format_version != expected_version:
        raise ModelError(
            f"{path}: the field 'format_version' is {head.format_version}, but this program reads "
            f"{expected_version}: update firstcontact, or train again"
        )
    return read_record(text, kind, str(path), remedy, LONGEST_CARD, ModelError)


def read_verified(path: Path, sha256: str, card: str, most: int) -> bytes:
    """Return the bytes of a file that ``card`` describes. Raise ModelError for another checksum.

    Also raises ModelError if the file cannot be read, and FileError above ``most`` bytes.
    """
    try:
        raw = read_regular(path, most)
    except OSError:
        raise ModelError(f"{path} cannot be read: copy the whole folder again") from None
    if digest(raw) != sha256:
        raise ModelError(
            f"{path} is damaged, or {card} belongs to another file (the checksums 'sha256' "
            "differ): copy the whole folder again"
        )
    return raw


def digest(data: bytes) -> str:
    """Return the SHA-256 checksum of data as 64 hexadecimal digits, as cards store it."""
    return hashlib.sha256(data).hexdigest()


def read_weights(path: Path, sha256: str, card: str) -> dict[str, NDArray[Any]]:
    """Return the arrays of a safetensors file by name. Raise ModelError if the file is damaged.

    ``sha256`` is the checksum that the file ``card`` states.
    """
    from safetensors import SafetensorError
    from safetensors.numpy import load

    raw = read_verified(path, sha256, card, LONGEST_WEIGHTS)
    try:
        # Parsing a header takes 30 times its size in memory.
        if int.from_bytes(raw[:8], "little") > LONGEST_CARD:
            raise ValueError
        arrays = load(raw)
    except (SafetensorError, ValueError, KeyError, TypeError):
        raise ModelError(f"{path} is not a safetensors file: train again") from None
    for name, array in arrays.items():
        if array.dtype in (np.uint8, np.int16):  # their reader checks them
            continue
        if not np.issubdtype(array.dtype, np.floating) or not np.isfinite(array).all():
            raise ModelError(
                f"{path}: the array '{name}' holds values that are not finite numbers: train again"
            )
    return arrays


def take_array(
    arrays: Mapping[str, NDArray[Any]], name: str, *shape: int | None
) -> NDArray[np.floating]:
    """Return the array called ``name``. Raise ModelError for another shape or invalid values.

    None in ``shape`` accepts any size of an axis.
    """
    if name not in arrays:
        raise ModelError(f"the array '{name}' is missing")
    array = arrays[name]
    if len(array.shape) != len(shape) or any(
        wanted not in (None, size) for size, wanted in zip(array.shape, shape, strict=True)
    ):
        wanted = ", ".join("any" if size is None else str(size) for size in shape)
        raise ModelError(f"the array '{name}' has shape {array.shape}; expected ({wanted})")
    if (
        not np.issubdtype(array.dtype, np.floating)
        or not (np.abs(array.astype(np.float64)) <= LARGEST).all()
    ):
        raise ModelError(
            f"the array '{name}' holds values that are not numbers from -{LARGEST:g} to {LARGEST:g}"
        )
    return array
