"""Checks of the folder that a training replaces."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from firstcontact.core import InputError


@dataclass(frozen=True, slots=True)
class _Format:
    """The field of a card that says whose it is."""

    format: str


def folder_name(ms: float) -> str:
    """Folder of the model for windows of this length, ms: 3 becomes "03ms"."""
    digits, dot, decimals = f"{ms:g}".partition(".")
    return f"{digits:0>2}{dot}{decimals}ms"


def check_replaceable(out: Path, models: Collection[str], anytime: bool = False) -> bool:
    """Refuse a folder that holds anything but models and a detector that are made again.

    Parameters
    ----------
    out
        The folder; it need not be there.
    models
        Folders of the models to come, below it; "" for itself.
    anytime
        True if a network is to come.

    Returns
    -------
    bool
        Whether a former training is there, which is to be replaced.

    Raises
    ------
    InputError
        Names what would be lost.
    """
    if not out.is_dir():
        return False
    from firstcontact.contact import DETECTOR_FORMAT, DETECTOR_WEIGHTS
    from firstcontact.core import DETECTOR_CARD
    from firstcontact.models import _anytime_file as anytime_file
    from firstcontact.models import _learned_from as learned_from
    from firstcontact.models import _model_file as model_file

    model_files = {model_file.CARD, model_file.WEIGHTS, learned_from.FILE}
    detector = {DETECTOR_CARD, DETECTOR_WEIGHTS}
    running = {anytime_file.CARD, anytime_file.WEIGHTS, anytime_file.PINCHES}
    _check_files(out, model_files | detector | running)
    _check_card(out / anytime_file.CARD, anytime_file.FORMAT)
    if anytime_file.has_anytime(out) and not anytime:
        raise _not_again(out)
    _check_card(out / DETECTOR_CARD, DETECTOR_FORMAT)
    for folder in (out, *sorted(p for p in out.iterdir() if p.is_dir())):
        if folder != out:
            if not (folder / model_file.CARD).is_file():
                raise _foreign(out, folder.name)
            _check_files(folder, model_files)
        _check_card(folder / model_file.CARD, model_file.FORMAT)
        name = "" if folder == out else folder.name
        if (folder / model_file.CARD).exists() and name not in models:
            raise _not_again(folder)
    return any(out.iterdir())


def replaced(out: Path) -> str:
    """Return the message that a former training was replaced."""
    return f"replaced the former training in {out}"


def _check_files(folder: Path, allowed: Collection[str]) -> None:
    for path in sorted(folder.iterdir()):
        if path.name not in allowed and not path.is_dir():
            raise _foreign(folder, path.name)


def _check_card(path: Path, form: str) -> None:
    from firstcontact.core import LONGEST_CARD, read_record, read_regular

    if not path.exists():
        return
    try:
        card = read_record(read_regular(path, LONGEST_CARD), _Format, "", "", LONGEST_CARD)
    except InputError:
        raise _foreign(path.parent, path.name) from None
    if card.format != form:
        raise _foreign(path.parent, path.name)


def _not_again(folder: Path) -> InputError:
    return InputError(
        f"{folder}: a model is here that would not be made again: "
        "name another folder for --out, or remove it"
    )


def _foreign(folder: Path, name: str) -> InputError:
    return InputError(
        f"{folder} holds {name}, which no training wrote, and would be replaced whole: "
        "name another folder for --out, or move it away"
    )
