"""Settings, sample types and layouts of imported files."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    Channel,
    ChannelKind,
    FileError,
    Finger,
    Layout,
    VibrationSensor,
    finger_name,
)
from firstcontact.core.given import given_number
from firstcontact.core.layout import TAXELS
from firstcontact.core.records import read_record
from firstcontact.core.text import parse_float
from firstcontact.core.units import STATE_UNIT, VOLT, VOLTS, Unit, fit_unit, parse_unit
from firstcontact.recording.messages import LARGEST
from firstcontact.recording.untrusted import as_text, quote

#: Settings of all pinches of a file. The rate and the sensor's unit are required, and the axis for
#: vectors.
SETTINGS = (
    "sample_rate_hz",
    *(f"{sensor}_unit" for sensor in VibrationSensor),
    "force_unit",
    "smoothing_alpha",
    "source",
    "axis",
)
#: Setting of exported files: the layout as JSON, if the names of the columns do not state it.
LAYOUT = "firstcontact_layout"
#: Lowest rate of a vibration, Hz, in files and live.
LOWEST_RATE = 500.0
#: Highest rate, Hz. A higher one is probably in a wrong unit.
HIGHEST_RATE = 1_000_000.0
#: Largest RMS of a vibration's rounding errors, as a share of its own RMS.
ROUNDING = 1e-3


def _parse_or_nan(value: Any) -> float:
    try:
        return parse_float(as_text(value))
    except ValueError:
        return math.nan


def given_rate(rate: float, parameter: str = "rate") -> float:
    """Return a caller's sampling rate, Hz. Raise ArgumentError outside 500 Hz to 1 MHz."""
    remedy = f"a sampling rate from {LOWEST_RATE:g} to {HIGHEST_RATE:g} Hz"
    return given_number(rate, parameter, LOWEST_RATE, HIGHEST_RATE, remedy)


def check_rate(origin: str, rate: Any) -> float:
    """Return a file's sampling rate, Hz. Raise FileError outside 500 Hz to 1 MHz.

    ``origin`` names the file and the field.
    """
    value = _parse_or_nan(rate)
    if not LOWEST_RATE <= value <= HIGHEST_RATE:
        raise FileError(
            f"{origin} is {quote(rate)}: give the sampling rate in Hz, from {LOWEST_RATE:g} to "
            f"{HIGHEST_RATE:g}"
        )
    return value


@dataclass(frozen=True, slots=True)
class FileSettings:
    """Settings that hold for all pinches of an imported file, such as rate and units."""

    sensor: VibrationSensor
    rate: float
    unit: Unit
    smoothing_alpha: float = 1.0
    axis: int | None = None  # axis of vectors, if stated
    force_unit: Unit = VOLT


def find_sensor(origin: str, names: Collection[str], remedy: str, end: str = "") -> VibrationSensor:
    """Return the one type of vibration sensor that the names of a file's signals state.

    ``end`` is a suffix that names may have. Raises FileError, with ``remedy``, unless there is
    exactly one type.
    """
    sensors = [s for s in VibrationSensor if {s, f"{s}_x", f"{s}{end}", f"{s}{end}_x"} & set(names)]
    if not sensors:
        raise FileError(f"{origin} has no {remedy}")
    if len(sensors) > 1:
        raise FileError(
            f"{origin} has {sensors[0]} and {sensors[1]} signals, but a recording has one kind of "
            "sensor: import them separately"
        )
    return sensors[0]


def read_settings(
    origin: str,
    given: Mapping[str, Any],
    sensor: VibrationSensor,
    vibration: NDArray[Any],
    force: NDArray[Any],
) -> FileSettings:
    """Parse the settings of an imported file, such as its rate, units and smoothing.

    ``given`` has the settings by the names in ``SETTINGS``. ``vibration`` and ``force`` are all
    samples, to check the units. Raises FileError for a missing or impossible setting.
    """
    unit_name = f"{sensor}_unit"
    for name in ("sample_rate_hz", unit_name):
        if name not in given:
            raise FileError(f"{origin} does not state '{name}': add it")
    alpha = as_text(given.get("smoothing_alpha", "1"))
    smoothing = _parse_or_nan(alpha)
    if not 0 < smoothing <= 1:
        raise FileError(
            f"{origin}: 'smoothing_alpha' is {quote(alpha)} and must be above 0 and at most "
            "1: use 1 for a signal that is not smoothed"
        )
    axis = as_text(given["axis"]) if "axis" in given else None
    if axis is not None and not (axis.isdecimal() and len(axis) <= 2):
        raise FileError(f"{origin}: 'axis' is {quote(axis)}: give the number of an axis, from 0")
    unit = _stated_unit(origin, unit_name, given[unit_name])
    force_unit = _stated_unit(origin, "force_unit", given.get("force_unit", VOLTS))
    if force_unit.name != VOLTS:
        raise FileError(f"{origin}: 'force_unit' is {force_unit.name}: convert forces to volts")
    return FileSettings(
        sensor,
        check_rate(f"{origin}: 'sample_rate_hz'", given["sample_rate_hz"]),
        fit_unit(f"{origin}: {sensor} ('{unit_name}')", unit, vibration),
        smoothing,
        None if axis is None else int(axis),
        fit_unit(f"{origin}: force ('force_unit')", force_unit, force, is_force=True),
    )


def _stated_unit(origin: str, name: str, value: Any) -> Unit:
    unit = parse_unit(as_text(value))
    if unit is None:
        raise FileError(f"{origin}: '{name}' is {quote(value)}: {STATE_UNIT}")
    return unit


def read_layout(origin: str, text: Any) -> Layout:
    """Parse the JSON layout that an exported file states. Raise FileError if it is unusable."""
    place, remedy = f"{origin}: '{LAYOUT}'", "export the recordings again"
    layout = read_record(as_text(text).encode(), Layout, place, remedy)
    if layout.why_unusable:
        raise FileError(f"{place} has {layout.why_unusable}: {remedy}")
    check_rate(f"{place}: rate", layout.rate)
    return layout


def check_samples(origin: str, values: NDArray[Any]) -> NDArray[Any]:
    """Convert integers to int16 or int32, and other numbers to float32.

    Raises FileError, with the name ``origin``, if values are missing, not finite or too large.
    """
    if values.dtype.kind not in "iuf":
        raise FileError(f"{origin} holds {values.dtype}: save integers or floats")
    if not values.size:
        raise FileError(f"{origin} is empty: give at least one sample of one pinch")
    if values.dtype.kind in "iu":
        low, high = int(values.min()), int(values.max())
        for dtype in (np.int16, np.int32):
            if np.iinfo(dtype).min <= low and high <= np.iinfo(dtype).max:
                return values.astype(dtype, copy=False)
        raise FileError(f"{origin} holds integers beyond 32 bits: scale them or give floats")
    with np.errstate(over="ignore", invalid="ignore"):
        single = values.astype(np.float32, copy=False)
    usable = np.abs(single) <= LARGEST
    if not usable.all():
        at = tuple(int(i) for i in np.argwhere(~usable)[0])
        raise FileError(
            f"{origin} is NaN, infinite or beyond {LARGEST:g} at index {at}: cut or repair the "
            "pinch"
        )
    return single


def is_rounded_away(pinches: Sequence[NDArray[Any]]) -> bool:
    """Return True if float32 is too coarse for the signals, as for a small one on a large offset.

    ``pinches`` are arrays of shape (samples, columns).
    """
    if pinches[0].dtype.kind != "f" or pinches[0].dtype.itemsize <= 4:
        return False
    errors = [(values - values.astype(np.float32)).var(axis=0) for values in pinches]
    variance = np.mean([values.var(axis=0) for values in pinches], axis=0)
    return bool((np.max(errors, axis=0) > ROUNDING**2 * variance).any())


def check_vibration(
    origin: str, values: NDArray[Any], pinches: Sequence[NDArray[Any]] = ()
) -> NDArray[Any]:
    """Convert a vibration like :func:`check_samples`. Raise FileError if float32 is too coarse.

    ``pinches`` are the parts of ``values`` to check, by default one.
    """
    samples = check_samples(origin, values)
    if is_rounded_away(pinches or [values]):
        raise FileError(
            f"{origin} has a vibration that is too small for 32-bit floats beside values of "
            f"{float(np.abs(values).max()):.6g}: subtract the offset, the same one in all files"
        )
    return samples


def common_type(parts: Sequence[NDArray[Any]]) -> np.dtype[Any]:
    """Return the data type (int16, int32 or float32) that can hold all of ``parts``."""
    kinds = {part.dtype.type for part in parts}
    return np.dtype(next((t for t in (np.float32, np.int32) if t in kinds), np.int16))


def joined(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Join arrays of columns side by side, in a data type that can hold all of them."""
    dtype = common_type(parts)
    return np.concatenate([p.astype(dtype, copy=False) for p in parts], axis=-1)


def make_layout(
    settings: FileSettings,
    sensors: int,
    *,
    scale: float | None = None,
    axes: int = 1,
    force: bool = False,
    strip: bool = False,
) -> Layout:
    """Return the layout of imported columns: vibration, then force, then contact strips.

    ``sensors`` is the number of vibration sensors, each with ``axes`` axes. ``scale`` replaces the
    scale of their unit. ``force`` and ``strip`` are True if these columns exist.
    """
    sensor, axis = settings.sensor, settings.axis
    if axes > 1 and (axis is None or axis >= axes):
        raise FileError(
            f"the {sensor} has {axes} axes, but 'axis', the axis that detectors use, is "
            f"{('missing' if axis is None else axis)}: give a number from 0 to {axes - 1}"
        )
    unit = settings.unit
    alone = sensors == 1 and sensor is not VibrationSensor.PIEZO
    channels = [
        Channel(
            sensor if finger is None else f"{sensor}_{finger_name(finger)}",
            ChannelKind.VIBRATION,
            finger,
            unit.name,
            unit.scale if scale is None else scale,
            unit.offset,
            sensor=sensor,
            smoothing_alpha=settings.smoothing_alpha,
            axes=axes,
            axis=(axis or 0) if axes > 1 else 0,
        )
        for finger in ([None] if alone else list(Finger)[:sensors])
    ]
    if force:
        volts = settings.force_unit.scale
        channels += [
            Channel(f"force_{finger_name(f)}_{k}", ChannelKind.FORCE, f, "V", volts, 0.0, taxel=k)
            for f in Finger
            for k in range(TAXELS)
        ]
    if strip:
        channels += [Channel(f"strip_{finger_name(f)}", ChannelKind.STRIP, f, "") for f in Finger]
    return Layout(tuple(channels), settings.rate)
