"""Models on disk: a folder with numbers in safetensors and a card in JSON. No code in either."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from firstcontact.core import InputError
from firstcontact.core.files import replacing, write_text
from firstcontact.stiffness.estimator import Arrays, Model, Spec, Task

FORMAT = "firstcontact-model"
#: Raised whenever older files can no longer be read.
FORMAT_VERSION = 1
CARD = "card.json"
WEIGHTS = "model.safetensors"
_LIBRARIES = ("firstcontact", "numpy", "scikit-learn", "torch", "onnxruntime")


@dataclass(frozen=True)
class Card:
    """Where a model comes from.

    Parameters
    ----------
    data
        ``source``, ``pinches``, ``sessions``, ``specimens``, ``contacts``
        (how the windows were aligned) and what else is known of the data.
    split
        How what the scores were computed on was held out, in words.
    scores
        On data that the scored model did not learn from.
    """

    data: Mapping[str, Any] = field(default_factory=dict)
    split: str = ""
    scores: Mapping[str, Any] = field(default_factory=dict)


def save_model(model: Model, directory: Path, card: Card) -> Path:
    """Write a model folder: the weights first, the card that vouches for them last.

    Parameters
    ----------
    model
        Any registered model.
    directory
        Made if it does not exist; a model in it is replaced.
    card
        What the model was trained on and how it scored.

    Returns
    -------
    Path
        The folder.
    """
    from safetensors.numpy import save

    arrays = {name: np.ascontiguousarray(a) for name, a in model.to_arrays().items()}
    weights = save(arrays, metadata={"format": FORMAT})
    spec = model.spec
    tree = {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "kind": model.kind,
        "task": spec.task.value,
        "rate_hz": spec.rate,
        "window_s": spec.duration,
        "samples": spec.samples,
        "channels": spec.channels,
        "channel_order": _order(spec.channels),
        "classes": list(spec.classes),
        "training": dict(model.notes),
        "data": dict(card.data),
        "split": card.split,
        "scores": dict(card.scores),
        "versions": _versions(),
        "sha256": hashlib.sha256(weights).hexdigest(),
    }
    text = json.dumps(tree, indent=2, allow_nan=False) + "\n"  # may refuse: before any file
    with replacing(directory / WEIGHTS) as temporary:
        temporary.write_bytes(weights)
    write_text(directory / CARD, text)
    return directory


def _versions() -> dict[str, str]:
    """Versions of what is installed of the libraries that train and run."""
    found = {}
    for name in _LIBRARIES:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def _order(channels: int) -> list[str]:
    """What each channel of a window is."""
    if channels == 1:
        return ["piezo of the finger that touched"]
    return ["piezo of the finger that touched", "piezo of the other finger"][:channels]


def load_model(path: Path) -> Model:
    """Read a model folder. Nothing in it is executed.

    Parameters
    ----------
    path
        The folder, or the card in it.

    Raises
    ------
    InputError
        A file that is missing, damaged, of another program or version, or
        whose numbers do not fit together.
    """
    from firstcontact.stiffness.registry import MODELS

    directory = path.parent if path.name == CARD else path
    card = _read_card(directory)
    spec = _spec(directory / CARD, card)
    if card["kind"] not in MODELS:
        raise InputError(
            f"{directory / CARD}: no model is of kind {card['kind']!r} "
            f"(there are {', '.join(MODELS)}): update firstcontact or train again"
        )
    arrays = _read_arrays(directory / WEIGHTS, card["sha256"])
    try:
        return MODELS[card["kind"]].from_arrays(spec, arrays)
    except KeyError as error:
        raise InputError(
            f"{directory / WEIGHTS}: the array {error} is missing: train again"
        ) from None
    except InputError as error:
        raise InputError(f"{directory / WEIGHTS}: {error}") from None
    except (ValueError, TypeError, IndexError, ArithmeticError):
        raise InputError(
            f"{directory / WEIGHTS}: the arrays are not those of a model of kind "
            f"{card['kind']!r}: train again"
        ) from None


def read_card(path: Path) -> dict[str, Any]:
    """The card of a model folder as it stands in the file; InputError as :func:`load_model`."""
    return _read_card(path.parent if path.name == CARD else path)


def _read_card(directory: Path) -> dict[str, Any]:
    path = directory / CARD
    try:
        card = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(
            f"{path}: there is no model here: name a folder that `firstcontact train` wrote"
        ) from None
    except (OSError, ValueError):
        raise InputError(f"{path}: cannot be read as JSON: train again or copy it again") from None
    if not isinstance(card, dict) or card.get("format") != FORMAT:
        raise InputError(f"{path}: is not the card of a firstcontact model (field format)")
    if card.get("format_version") != FORMAT_VERSION:
        raise InputError(
            f"{path}: format_version is {card.get('format_version')!r} but this program reads "
            f"{FORMAT_VERSION}: update firstcontact, or train again"
        )
    return card


def _spec(path: Path, card: Mapping[str, Any]) -> Spec:
    try:
        spec = Spec(
            Task(card["task"]),
            float(card["rate_hz"]),
            int(card["samples"]),
            int(card["channels"]),
            tuple(float(c) for c in card["classes"]),
        )
        ready = card["kind"], card["sha256"], card["data"]["sessions"]
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"{path}: a field is missing or has no sensible value ({error}): train again"
        ) from None
    if not all(isinstance(text, str) for text in ready[:2]) or not (
        np.isfinite(spec.rate) and spec.rate > 0 and spec.samples > 0 and spec.channels > 0
    ):
        raise InputError(f"{path}: a field has no sensible value (rate_hz, samples): train again")
    if (spec.task is Task.CLASSIFICATION) != (len(spec.classes) > 1):
        raise InputError(f"{path}: classes do not fit the task {spec.task}: train again")
    if card.get("channel_order") != _order(spec.channels):
        raise InputError(
            f"{path}: channel_order is {card.get('channel_order')!r} but windows here hold "
            f"{_order(spec.channels)!r}: train again"
        )
    return spec


def _read_arrays(path: Path, sha256: str) -> Arrays:
    from safetensors import SafetensorError
    from safetensors.numpy import load

    try:
        raw = path.read_bytes()
    except OSError:
        raise InputError(f"{path}: cannot be read: copy the model folder whole") from None
    if hashlib.sha256(raw).hexdigest() != sha256:
        raise InputError(
            f"{path}: its content does not match sha256 in {CARD}: "
            "the file is damaged or of another model: copy the folder again"
        )
    try:
        arrays = load(raw)
    except (SafetensorError, ValueError, KeyError, TypeError):
        raise InputError(f"{path}: is not a safetensors file: train again") from None
    for name, array in arrays.items():
        if not np.issubdtype(array.dtype, np.floating) or not np.isfinite(array).all():
            raise InputError(f"{path}: the array {name} holds values that are not finite numbers")
    return arrays
