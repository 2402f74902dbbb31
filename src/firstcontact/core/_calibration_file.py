"""Reader and writer of calibration files, ``calibration.json``."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from firstcontact.core._calibration import Calibration
from firstcontact.core._errors import InputError
from firstcontact.core._files import AnyPath, given_path, read_regular, try_replacing, write_json
from firstcontact.core._layout import finger_name
from firstcontact.core._records import LONGEST, read_record

_REMEDY = "make a calibration with `firstcontact calibrate`"
#: Name and version of the format. Other formats and versions are refused.
FORMAT = "firstcontact.calibration"
VERSION = 1


@dataclass(frozen=True, slots=True)
class _Head:
    """Fields that identify a file as a calibration, and its version."""

    format: str = ""
    version: int | None = None


def write_calibration(calibration: Calibration, path: Path) -> None:
    """Write a calibration atomically and replace an existing file.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    try:
        write_json(path, {"format": FORMAT, "version": VERSION, **calibration.to_json()})
    except OSError as error:
        raise _unwritable(path, error) from error


def check_writable(path: Path) -> None:
    """Check that a path can be written before a long measurement. Leave no file there.

    Raises
    ------
    InputError
        :func:`write_calibration` could not write the path.
    """
    try:
        try_replacing(path)
    except OSError as error:
        raise _unwritable(path, error) from error


def read_calibration(path: Path) -> Calibration:
    """Read a file that :func:`write_calibration` wrote.

    Raises
    ------
    InputError
        The file cannot be read, is not a calibration, has another version, or holds a number
        that is out of range.
    """
    try:
        data = read_regular(path, LONGEST)
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror}): check the path") from error
    head = read_record(data, _Head, str(path), _REMEDY)
    if head.format != FORMAT:
        raise _foreign(path, f'its format is not "{FORMAT}"')
    if head.version != VERSION:
        raise _foreign(path, f"its version is {head.version} and not {VERSION}")
    calibration = read_record(data, Calibration, str(path), _REMEDY)
    for piezo in calibration.piezo:
        if not piezo.noise > 0:
            raise _foreign(path, f"the {finger_name(piezo.finger)}'s noise is 0")
    return calibration


def given_calibration(calibration: Calibration | AnyPath | None) -> Calibration | None:
    """Return a calibration that a caller gave, read from its file if a path was given.

    Raises
    ------
    InputError
        See :func:`read_calibration`.
    """
    if isinstance(calibration, str | os.PathLike):
        return read_calibration(given_path(calibration, "calibration"))
    return calibration


def _unwritable(path: Path, error: OSError) -> InputError:
    return InputError(f"{path} cannot be written ({error.strerror}): choose another file")


def _foreign(path: Path, reason: str) -> InputError:
    return InputError(f"{path} is not a calibration ({reason}): {_REMEDY}")
