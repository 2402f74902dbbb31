"""What was learned, on disk: numbers in safetensors, and a JSON card that vouches for them.

No code is in either, and none is run.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.errors import InputError
from firstcontact.core.files import replacing, write_text

_LIBRARIES = ("firstcontact", "numpy", "scikit-learn", "torch", "onnxruntime", "mapie")


def write_learned(
    card: Path, weights: Path, tree: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]
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

    Raises
    ------
    ValueError
        A card that JSON cannot hold, before any file is touched.
    """
    from safetensors.numpy import save

    # Not ascontiguousarray, which gives a number an axis.
    whole = {name: np.asarray(a, order="C") for name, a in arrays.items()}
    raw = save(whole, metadata={"format": tree["format"]}) if whole else None
    digest = None if raw is None else hashlib.sha256(raw).hexdigest()
    full = {**tree, "versions": _versions(), "sha256": digest}
    text = json.dumps(full, indent=2, allow_nan=False) + "\n"
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


def read_head(path: Path, what: str, form: str, form_version: int) -> dict[str, Any]:
    """A card, its ``format`` and ``format_version`` checked.

    Parameters
    ----------
    path
        The card.
    what
        "model" or "detector", for messages.
    form, form_version
        What the two fields must be.

    Raises
    ------
    InputError
        Missing, damaged, of something else or of another version.
    """
    try:
        card = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(
            f"{path}: there is no {what} here: name a folder that `firstcontact train` wrote"
        ) from None
    except (OSError, ValueError):
        raise InputError(f"{path}: cannot be read as JSON: train again or copy it again") from None
    if not isinstance(card, dict) or card.get("format") != form:
        raise InputError(f"{path}: is not the card of a firstcontact {what} (field format)")
    if card.get("format_version") != form_version:
        raise InputError(
            f"{path}: format_version is {card.get('format_version')!r} but this program reads "
            f"{form_version}: update firstcontact, or train again"
        )
    return card


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

    try:
        raw = path.read_bytes()
    except OSError:
        raise InputError(f"{path}: cannot be read: copy the folder whole") from None
    if hashlib.sha256(raw).hexdigest() != sha256:
        raise InputError(
            f"{path}: its content does not match sha256 in {card}: "
            "the file is damaged or belongs to another card: copy the folder again"
        )
    try:
        arrays = load(raw)
    except (SafetensorError, ValueError, KeyError, TypeError):
        raise InputError(f"{path}: is not a safetensors file: train again") from None
    for name, array in arrays.items():
        if not np.issubdtype(array.dtype, np.floating) or not np.isfinite(array).all():
            raise InputError(f"{path}: the array {name} holds values that are not finite numbers")
    return arrays
