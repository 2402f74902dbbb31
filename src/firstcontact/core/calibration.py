"""Calibration of a pair of fingertips before a recording, and functions for calibration files."""

from __future__ import annotations

import errno
import math
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from firstcontact.core._errors import ArgumentError, FileError, InputError
from firstcontact.core.board import DIVIDER_OHM
from firstcontact.core.files import AnyPath, given_path, read_regular, write_json
from firstcontact.core.given import given_choice, given_number
from firstcontact.core.layout import ADC_VOLTS, Finger
from firstcontact.core.records import LONGEST, Name, read_record

_REMEDY = "make a calibration with `firstcontact calibrate`"
#: Name and version of the format. Other formats and versions are refused.
FORMAT = "firstcontact.calibration"
VERSION = 1
#: Bounds of the numbers in a calibration.
Size = Annotated[float, Meta(ge=0.0, le=1e9)]
Positive = Annotated[float, Meta(gt=0.0, le=1e9)]


def _check_fields(record: Any, *, positive: Sequence[str], size: Sequence[str]) -> None:
    """Convert a record's finger to Finger, and its numbers to float. Check their values.

    ``record`` is changed in place. The values of the fields named in ``positive`` must be above 0.
    Those of the fields named in ``size`` must be 0 or more, or None. Raises ArgumentError
    for any other value.
    """
    if record.finger is not None:
        object.__setattr__(record, "finger", given_choice(Finger, record.finger, "finger"))
    for name in (*positive, *size):
        if (value := getattr(record, name)) is None and name in size:
            continue
        least, words = (5e-324, "above 0") if name in positive else (0.0, "from 0 on")
        # Noise is infinite for a finger whose motor cannot be heard.
        number = given_number(value, name, least, math.inf, f"a number {words}")
        object.__setattr__(record, name, number)


@dataclass(frozen=True, slots=True)
class VibrationCalibration:
    """Noise and offset of one vibration sensor, measured while the hand rests without contact.

    Parameters
    ----------
    finger
        Finger that carries the sensor; None if it belongs to no finger.
    noise
        Standard deviation of the resting signal, in the channel's unit (V for fingertips), above 0.
    offset
        Mean of the resting signal, in the channel's unit, after the nominal offset (1.65 V for
        fingertips) was subtracted.
    tap
        Peak of the signal when a person taps the finger, in the channel's unit; None without a tap.
    """

    finger: Finger | None
    noise: Size
    offset: Annotated[float, Meta(ge=-1e9, le=1e9)] = 0.0
    tap: Size | None = None

    def __post_init__(self) -> None:
        _check_fields(self, positive=("noise",), size=("tap",))
        given_number(self.offset, "offset", -1e9, 1e9)


@dataclass(frozen=True, slots=True)
class ForceCurve:
    """Force curve of one fingertip's Velostat sensor, which converts its voltages to newtons.

    Velostat is a sheet whose conductance g rises with the force F: ``g = leak + gain F^exponent``.
    Sheet and resistor R form a voltage divider. R then has the voltage ``V = 3.3 R g / (1 + R g)``.

    Parameters
    ----------
    finger
        Finger that carries the Velostat.
    leak
        Conductance without load, in siemens.
    gain
        Factor on the force, in siemens / newton^exponent.
    exponent
        Exponent of the force.
    rms
        Root mean square of the differences between this curve and the measured forces, N.
    resistor
        Resistance R of the divider's resistor, ohm.
    """

    finger: Finger
    leak: Size
    gain: Positive
    exponent: Positive
    rms: Size
    resistor: Positive = DIVIDER_OHM

    def __post_init__(self) -> None:
        _check_fields(self, positive=("gain", "exponent", "resistor"), size=("leak", "rms"))

    def newtons(self, volts: NDArray[Any]) -> NDArray[np.float64]:
        """Convert voltages over the divider's resistor, V, to forces on a taxel (force cell), N."""
        ratio = np.clip(np.asarray(volts, dtype=np.float64) / ADC_VOLTS, 0.0, 0.999)
        conductance = ratio / (1.0 - ratio) / self.resistor
        newtons: NDArray[np.float64] = (np.maximum(conductance - self.leak, 0.0) / self.gain) ** (
            1.0 / self.exponent
        )
        return newtons


@dataclass(frozen=True, slots=True)
class Calibration:
    """Noise floors and force curves of one pair of fingertips, stored in every recording.

    The noise floors let the live program see when the motor starts to close the hand.

    Parameters
    ----------
    piezo
        Noise and offset of each measured vibration sensor. The sensors may also be accelerometers
        or microphones.
    force
        Force curve of each fingertip whose force was calibrated.
    created
        Time of the measurement as ISO 8601 text; "" if unknown.

    Examples
    --------
    >>> import firstcontact as fc
    >>> from firstcontact.core import VibrationCalibration
    >>> calibration = fc.Calibration((VibrationCalibration(fc.Finger.INDEX, noise=0.002),))
    >>> calibration.noise(fc.Finger.INDEX)
    0.002
    """

    piezo: Annotated[tuple[VibrationCalibration, ...], Meta(max_length=len(Finger) + 1)] = ()
    force: Annotated[tuple[ForceCurve, ...], Meta(max_length=len(Finger))] = ()
    created: Name = ""

    def __post_init__(self) -> None:
        for name, kind in (("piezo", VibrationCalibration), ("force", ForceCurve)):
            parts = getattr(self, name)
            parts = (parts,) if isinstance(parts, kind) else tuple(parts)
            object.__setattr__(self, name, parts)
            fingers = [part.finger for part in parts if isinstance(part, kind)]
            if len(set(fingers)) < len(parts):
                message = f"give one {kind.__name__} for each finger"
                raise ArgumentError(message, parameter=name)

    def noise(self, finger: Finger | None) -> float | None:
        """Return the resting noise of a finger's vibration sensor; None if not measured.

        It is the :attr:`VibrationCalibration.noise`, in the channel's unit.
        """
        return next((p.noise for p in self.piezo if p.finger is finger), None)

    def to_json(self) -> dict[str, Any]:
        """Return the calibration as dicts and lists for JSON."""
        return asdict(self)


@dataclass(frozen=True, slots=True)
class _Head:
    """Name and version of the format of a calibration file."""

    format: str = ""
    version: int | None = None


def write_calibration(calibration: Calibration, path: Path) -> None:
    """Write a calibration file atomically. Replace an existing file."""
    try:
        write_json(path, {"format": FORMAT, "version": VERSION, **calibration.to_json()})
    except OSError as error:
        raise _unwritable(path, error) from error


def check_writable(path: Path) -> None:
    """Raise FileError if the file ``path`` cannot be written. Call it before a measurement."""
    folder = next(parent for parent in path.absolute().parents if parent.exists())
    if path.is_dir():
        fault = errno.EISDIR
    elif not folder.is_dir():
        fault = errno.ENOTDIR
    elif not os.access(folder, os.W_OK | os.X_OK):
        fault = errno.EACCES
    else:
        return
    raise _unwritable(path, OSError(fault, os.strerror(fault)))


def read_calibration(path: Path) -> Calibration:
    """Read a calibration file. Raise FileError if it cannot be read or is not a calibration."""
    try:
        data = read_regular(path, LONGEST)
    except OSError as error:
        raise FileError(f"{path} cannot be read ({error.strerror}): check the path") from error
    head = read_record(data, _Head, str(path), _REMEDY)
    if head.format != FORMAT:
        raise _foreign(path, f'its format is not "{FORMAT}"')
    if head.version != VERSION:
        raise _foreign(path, f"its version is {head.version} and not {VERSION}")
    return read_record(data, Calibration, str(path), _REMEDY)


def given_calibration(calibration: Calibration | AnyPath | None) -> Calibration | None:
    """Read a calibration file if the caller gave a path. Return any other argument unchanged."""
    if isinstance(calibration, str | os.PathLike):
        return read_calibration(given_path(calibration, "calibration"))
    return calibration


def _unwritable(path: Path, error: OSError) -> InputError:
    return FileError(f"{path} cannot be written ({error.strerror}): choose another file")


def _foreign(path: Path, reason: str) -> InputError:
    return FileError(f"{path} is not a calibration ({reason}): {_REMEDY}")
