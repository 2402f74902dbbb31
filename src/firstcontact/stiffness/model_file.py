"""Models on disk: a folder with numbers in safetensors and a card in JSON. No code in either."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from firstcontact.core import InputError
from firstcontact.core.weights import read_head, read_weights, write_learned
from firstcontact.stiffness.estimator import Model, Spec, Task
from firstcontact.stiffness.interval import Interval

FORMAT = "firstcontact-model"
#: Raised whenever older files can no longer be read.
FORMAT_VERSION = 1
CARD = "card.json"
WEIGHTS = "model.safetensors"


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
    interval
        Around the answers of a regression; None where there is none.
    calibration
        What the interval was calibrated on and how many truths it held, or
        ``none`` with the reason why there is no interval.
    """

    data: Mapping[str, Any] = field(default_factory=dict)
    split: str = ""
    scores: Mapping[str, Any] = field(default_factory=dict)
    interval: Interval | None = None
    calibration: Mapping[str, Any] = field(default_factory=dict)


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
        "interval": None if card.interval is None else card.interval.to_json(),
        "calibration": dict(card.calibration),
    }
    write_learned(directory / CARD, directory / WEIGHTS, tree, model.to_arrays())
    return directory


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

    directory = _folder(path)
    card = read_card(directory)
    spec = _spec(directory / CARD, card)
    if card["kind"] not in MODELS:
        raise InputError(
            f"{directory / CARD}: no model is of kind {card['kind']!r} "
            f"(there are {', '.join(MODELS)}): update firstcontact or train again"
        )
    arrays = read_weights(directory / WEIGHTS, card["sha256"], CARD)
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
    return read_head(_folder(path) / CARD, "model", FORMAT, FORMAT_VERSION)


def _folder(path: Path) -> Path:
    return path.parent if path.name == CARD else path


def load_interval(path: Path) -> Interval | None:
    """The interval in a model's card, None where the model has none.

    Parameters
    ----------
    path
        The folder, or the card in it.

    Raises
    ------
    InputError
        As :func:`load_model`, and for an interval whose numbers do not fit.
    """
    tree = read_card(path).get("interval")
    if tree is None:
        return None
    try:
        return Interval.from_json(tree)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"{_folder(path) / CARD}: interval has no sensible value ({error}): train again"
        ) from None


def model_folders(path: Path) -> list[Path]:
    """Folders of the models that one training left: ``path`` itself, or those in it.

    Parameters
    ----------
    path
        What ``firstcontact train`` was given as ``--out``, or one model's folder.

    Returns
    -------
    list of Path
        Shortest window first, where they are named as training names them.

    Raises
    ------
    InputError
        No model is there.
    """
    folder = _folder(path)
    if (folder / CARD).exists():
        return [folder]
    found = sorted(card.parent for card in folder.glob(f"*/{CARD}"))
    if not found:
        raise InputError(
            f"{folder}: there is no model here: name a folder that `firstcontact train` wrote"
        )
    return found


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
