"""Models on disk: a folder with numbers in safetensors and a card in JSON. No code in either."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from firstcontact.core import (
    DETECTOR_CARD,
    LONGEST_CARD,
    AnyPath,
    InputError,
    digest,
    displaced_folder,
    read_regular,
    read_weights,
    replacing,
    require_extra,
    write_weights,
)
from firstcontact.core import read_card as read_checked
from firstcontact.models._card import ModelCard, Provenance
from firstcontact.models._interval import Interval
from firstcontact.models._learned_from import FILE as PINCHES
from firstcontact.models._learned_from import Digests, read_digests, to_bytes
from firstcontact.models._model import WindowModel
from firstcontact.models._spec import Spec, Task

FORMAT = "firstcontact-model"
#: Raised whenever older files can no longer be read.
FORMAT_VERSION = 1
CARD = "card.json"
WEIGHTS = "model.safetensors"
#: Longest window that a model may ask for, s.
LONGEST_WINDOW = 10.0


def save_model(
    model: WindowModel, directory: AnyPath, card: Provenance, learned_from: Digests | None = None
) -> Path:
    """Write a model folder: the weights first, last the card with their checksum.

    Parameters
    ----------
    model
        Any registered model.
    directory
        Made if it does not exist; a model in it is replaced.
    card
        What the model was trained on and how it scored.
    learned_from
        Of the pinches, by :func:`pinch_digests`; None where they are not known.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    InputError
        A card that could not be read again.
    ValueError
        A card that JSON cannot hold.
    """
    directory, spec = Path(directory), model.spec
    digests = None if learned_from is None else to_bytes(learned_from)
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
        "data": card.data.to_json(),
        "split": card.split,
        "scores": dict(card.scores),
        "interval": None if card.interval is None else card.interval.to_json(),
        "calibration": dict(card.conformal),
        "detector": card.detector,
        "pinches_sha256": None if digests is None else digest(digests),
    }
    file = directory / PINCHES
    if digests is not None:
        with replacing(file) as temporary:
            temporary.write_bytes(digests)
    write_weights(directory / CARD, directory / WEIGHTS, tree, model.to_arrays(), ModelCard)
    if digests is None:
        file.unlink(missing_ok=True)
    return directory


def _order(channels: int) -> list[str]:
    """Return the description of each channel of a window."""
    if channels == 1:
        return ["piezo of the finger that touched"]
    return ["piezo of the finger that touched", "piezo of the other finger"][:channels]


def load_window_model(path: AnyPath) -> WindowModel:
    """Read a model folder. Nothing in it is executed.

    Parameters
    ----------
    path
        The folder, or the card in it.

    Raises
    ------
    InputError
        A file that is missing, damaged, of another program or version, or
        whose numbers do not fit together; a detector beside it that is of
        another training.
    """
    from firstcontact.models._registry import model_kind

    directory = _folder(path)
    card = read_card(directory)
    spec = _spec(directory / CARD, card)
    try:
        kind = model_kind(card.kind)
    except InputError as error:
        raise InputError(
            f"{directory / CARD}: {error}: update firstcontact or train again"
        ) from None
    require_extra(kind)
    _check_detector(directory, card)
    arrays = read_weights(directory / WEIGHTS, card.sha256, CARD)
    try:
        with np.errstate(all="ignore"):  # what overflows here is refused where it is asked for
            return kind.from_arrays(spec, arrays)
    except KeyError as error:
        raise InputError(
            f"{directory / WEIGHTS}: the array {error} is missing: train again"
        ) from None
    except InputError as error:
        raise InputError(f"{directory / WEIGHTS}: {error}") from None
    except (ValueError, TypeError, IndexError, ArithmeticError):
        raise InputError(
            f"{directory / WEIGHTS}: the arrays are not those of a model of kind "
            f"{card.kind!r}: train again"
        ) from None


def read_card(path: AnyPath) -> ModelCard:
    """The card of a model folder, its fields checked; InputError as :func:`load_model`."""
    return read_checked(_folder(path) / CARD, "model", FORMAT, FORMAT_VERSION, ModelCard)


def _folder(path: AnyPath) -> Path:
    folder = Path(path)
    return folder.parent if folder.name == CARD else folder


def load_interval(path: AnyPath) -> Interval | None:
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
    return read_card(path).interval


def load_digests(path: AnyPath) -> Digests | None:
    """Digests of the pinches that a model learned from; None where it does not say.

    Raises
    ------
    InputError
        As :func:`load_model`.
    """
    folder = _folder(path)
    vouched = read_card(folder).pinches_sha256
    return None if vouched is None else read_digests(folder / PINCHES, vouched, CARD)


def has_models(path: AnyPath) -> bool:
    """Return True if a model is in a folder, or in one below it."""
    folder = _folder(path)
    return (folder / CARD).exists() or any(folder.glob(f"*/{CARD}"))


def model_folders(path: AnyPath) -> list[Path]:
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
    folders = sorted(card.parent for card in folder.glob(f"*/{CARD}"))
    if not folders:
        aside = displaced_folder(folder)
        if aside is not None:
            raise InputError(
                f"{folder}: a training was killed while it replaced this folder: rename {aside}, "
                "which was here, or train again"
            )
        raise InputError(
            f"{folder}: there is no model here: name a folder that `firstcontact train` wrote"
        )
    return folders


def _check_detector(directory: Path, card: ModelCard) -> None:
    """Refuse the detector beside a model, or above it, that is not the one it was trained with."""
    if card.detector is None:
        return
    for folder in (directory, directory.parent):
        file = folder / DETECTOR_CARD
        if not file.exists():
            continue
        try:
            card_bytes = read_regular(file, LONGEST_CARD)
        except OSError as error:
            raise InputError(f"{file}: cannot be read ({error.strerror}): check the file") from None
        if digest(card_bytes) != card.detector:
            raise InputError(
                f"{file}: is not the detector that {directory / CARD} was trained with: "
                "copy the whole folder again, or train again"
            )
        return


def _spec(path: Path, card: ModelCard) -> Spec:
    spec = Spec(card.task, card.rate_hz, card.samples, card.channels, card.classes)
    if spec.duration > LONGEST_WINDOW:
        raise InputError(
            f"{path}: {spec.samples} samples at {spec.rate:g} Hz are more than "
            f"{LONGEST_WINDOW:g} s: train again"
        )
    if (spec.task is Task.CLASSIFICATION) != (len(spec.classes) > 1) or any(
        not one < other for one, other in zip(spec.classes, spec.classes[1:], strict=False)
    ):
        raise InputError(
            f"{path}: classes do not fit the task {spec.task}, or do not ascend: train again"
        )
    if list(card.channel_order) != _order(spec.channels):
        raise InputError(
            f"{path}: channel_order is {list(card.channel_order)!r} but windows here hold "
            f"{_order(spec.channels)!r}: train again"
        )
    return spec
