"""A calibration as a file of its own, ``calibration.json``."""

from __future__ import annotations

import json
import math
from pathlib import Path

from firstcontact.core.calibration import Calibration
from firstcontact.core.errors import InputError
from firstcontact.core.files import try_replacing, write_json

#: Name and version of the format; anything else is refused.
FORMAT = "firstcontact.calibration"
VERSION = 1


def write_calibration(calibration: Calibration, path: Path) -> None:
    """Write it whole, over what was there.

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
    """Try a path before the work whose result it is to hold; nothing is left there.

    Raises
    ------
    InputError
        :func:`write_calibration` could not write it.
    """
    try:
        try_replacing(path)
    except OSError as error:
        raise _unwritable(path, error) from error


def read_calibration(path: Path) -> Calibration:
    """Read what :func:`write_calibration` wrote.

    Raises
    ------
    InputError
        The file cannot be read, is no calibration or of another version, or a
        number in it is not one.
    """
    try:
        tree = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror}): check the path") from error
    except ValueError as error:
        raise _foreign(path, "it is not JSON") from error
    if not isinstance(tree, dict) or tree.get("format") != FORMAT:
        raise _foreign(path, f'its format is not "{FORMAT}"')
    if tree.get("version") != VERSION:
        raise _foreign(path, f"its version is {tree.get('version')!r} and not {VERSION}")
    try:
        calibration = Calibration.from_json(tree)
        _check(path, calibration)
    except (KeyError, ValueError, TypeError) as error:
        if isinstance(error, InputError):
            raise
        raise _foreign(path, f"it is not complete, {error!r}") from error
    return calibration


def _check(path: Path, calibration: Calibration) -> None:
    for piezo in calibration.piezo:
        if not (math.isfinite(piezo.noise) and piezo.noise > 0 and math.isfinite(piezo.offset)):
            raise _foreign(path, f"the {piezo.finger.name.lower()}'s noise or offset is no voltage")
    for curve in calibration.force:
        numbers = (curve.gain, curve.exponent, curve.resistor)
        if not all(math.isfinite(x) and x > 0 for x in numbers) or not curve.leak >= 0:
            raise _foreign(path, f"the {curve.finger.name.lower()}'s force curve is none")


def _unwritable(path: Path, error: OSError) -> InputError:
    return InputError(f"{path} cannot be written ({error.strerror}): choose another file")


def _foreign(path: Path, why: str) -> InputError:
    return InputError(
        f"{path} is not a calibration ({why}): make one with `firstcontact calibrate`"
    )
