"""What every importer asks of signals, rates and layouts."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    ADC_COUNTS,
    ADC_VOLTS,
    FINGERTIP_RATE,
    FINGERTIP_SMOOTHING,
    PIEZO_OFFSET_VOLTS,
    TAXELS,
    Channel,
    ChannelKind,
    Finger,
    InputError,
    Layout,
    VibrationSensor,
    finger_name,
    parse_float,
)
from firstcontact.recording._header import SOURCES
from firstcontact.recording._quoting import quote, text_of
from firstcontact.recording._samples import LARGEST

#: What holds for all pinches of a file; the rate and the sensor's unit must be given, and of
#: vectors the axis.
SETTINGS = (
    "sample_rate_hz",
    *(f"{sensor}_unit" for sensor in VibrationSensor),
    "force_unit",
    "smoothing_alpha",
    "source",
    "axis",
)
#: Slowest rate at which 15 ms of a contact still say something, Hz.
LOWEST_RATE = 2_000.0
#: Faster than any sensor of this kind: most likely a slip of unit, Hz.
HIGHEST_RATE = 1_000_000.0
#: Units of a vibration channel: scale and offset of ``(raw - offset) * scale``.
UNITS = {
    "V": (1.0, 0.0),
    "counts": (ADC_VOLTS / ADC_COUNTS, PIEZO_OFFSET_VOLTS * ADC_COUNTS / ADC_VOLTS),
    "full scale": (1.0, 0.0),
    "m/s2": (1.0, 0.0),
    "Pa": (1.0, 0.0),
}
#: Units of a force channel: volts per step. A taxel's voltage is none beyond this, V.
FORCE_UNITS = {"V": 1.0, "counts": ADC_VOLTS / ADC_COUNTS}
FORCE_MOST = 10.0


def check_rate(where: str, rate: Any) -> float:
    """The rate, if a sensor can have it.

    Raises
    ------
    InputError
        Not a number, or outside 2 kHz to 1 MHz.
    """
    try:
        # The imaginary part of a complex one would be dropped with a warning.
        value = math.nan if np.iscomplexobj(rate) else parse_float(text_of(rate))
    except ValueError:
        value = math.nan
    if not LOWEST_RATE <= value <= HIGHEST_RATE:
        raise InputError(
            f"{where} is {quote(rate)} and must be from {LOWEST_RATE:g} to {HIGHEST_RATE:g}: "
            "give samples a second, recorded at 2 kHz or faster"
        )
    return value


@dataclass(frozen=True, slots=True)
class FileSettings:
    """What holds for all pinches of a stranger's file."""

    sensor: VibrationSensor
    rate: float
    unit: str
    smoothing_alpha: float
    source: str  # "unknown" where nothing says it
    axis: int | None  # of vectors, where it is said
    force_unit: str = "V"

    @property
    def notes(self) -> list[str]:
        """What a reader of results must know of these settings, one sentence each."""
        usual = self.smoothing_alpha == FINGERTIP_SMOOTHING and self.rate == FINGERTIP_RATE
        if self.smoothing_alpha == 1.0 or usual:
            return []
        return [
            f"the {self.sensor} came smoothed (alpha {self.smoothing_alpha:g} at {self.rate:g} Hz) "
            f"and is not smoothed again, so it differs from the device's {FINGERTIP_SMOOTHING:g} "
            f"at {FINGERTIP_RATE:g} Hz"
        ]


def find_sensor(where: str, there: Collection[str], remedy: str, end: str = "") -> VibrationSensor:
    """The sensor whose signal a file holds, by its name.

    Parameters
    ----------
    where
        That messages name.
    there
        Names in the file.
    remedy
        How to give a signal.
    end
        Behind a sensor's name, where one finger's signal is looked for too.

    Raises
    ------
    InputError
        There is none, or several are there.
    """
    found = [s for s in VibrationSensor if {s, f"{s}_x", f"{s}{end}", f"{s}{end}_x"} & set(there)]
    if not found:
        raise InputError(f"{where} has no {remedy}")
    if len(found) > 1:
        raise InputError(f"{where} has {found[0]} and {found[1]}: import one of them at a time")
    return found[0]


def read_settings(
    where: str, given: Mapping[str, Any], sensor: VibrationSensor = VibrationSensor.PIEZO
) -> FileSettings:
    """What a file says of itself and its sensor, under the names of :data:`SETTINGS`.

    Raises
    ------
    InputError
        ``sample_rate_hz`` or the unit is missing, or a value is impossible.
    """
    of_unit = f"{sensor}_unit"
    for name in ("sample_rate_hz", of_unit):
        if name not in given:
            raise InputError(f"{where} does not say {name}: add it")
    rate = check_rate(f"{where}: sample_rate_hz", given["sample_rate_hz"])
    unit = text_of(given[of_unit])
    if unit not in UNITS:
        raise InputError(
            f"{where}: {of_unit} is {quote(unit)} and must be one of {', '.join(UNITS)}"
        )
    force_unit = text_of(given.get("force_unit", "V"))
    if force_unit not in FORCE_UNITS:
        raise InputError(
            f"{where}: force_unit is {quote(force_unit)} and must be one of "
            f"{', '.join(FORCE_UNITS)}: convert force to volts, or leave it out"
        )
    alpha = text_of(given.get("smoothing_alpha", "1"))
    try:
        smoothing = parse_float(alpha)
    except ValueError:
        smoothing = math.nan
    if not 0 < smoothing <= 1:
        raise InputError(
            f"{where}: smoothing_alpha is {quote(alpha)} and must be above 0 and at most 1 "
            "(not smoothed)"
        )
    axis = text_of(given["axis"]) if "axis" in given else None
    if axis is not None and not (axis.isdecimal() and len(axis) < len("100")):
        raise InputError(f"{where}: axis is {quote(axis)} and must count from 0")
    source = check_source(where, given.get("source", "unknown"))
    which = None if axis is None else int(axis)
    return FileSettings(sensor, rate, unit, smoothing, source, which, force_unit)


def check_source(where: str, said: Any) -> str:
    """What a file says it comes from, if recordings have a word for it.

    Raises
    ------
    InputError
        It is none of :data:`firstcontact.recording._header.SOURCES`.
    """
    source = text_of(said)
    if source not in SOURCES:
        raise InputError(
            f"{where}: source is {quote(source)} and must be one of {', '.join(SOURCES)}"
        )
    return source


def check_samples(where: str, values: NDArray[Any]) -> NDArray[Any]:
    """Samples as int16, int32 or float32, whichever holds them without loss of meaning.

    Raises
    ------
    InputError
        No numbers, nothing in it, NaN or infinite, or too large.
    """
    if values.dtype.kind not in "iuf":
        raise InputError(f"{where} holds {values.dtype} and must hold integers or floats")
    if not values.size:
        raise InputError(f"{where} is empty: give at least one sample of one pinch")
    if values.dtype.kind in "iu":
        low, high = int(values.min()), int(values.max())
        for dtype in (np.int16, np.int32):
            if np.iinfo(dtype).min <= low and high <= np.iinfo(dtype).max:
                return values.astype(dtype, copy=False)
        raise InputError(f"{where} holds integers beyond 32 bits: scale them or give floats")
    with np.errstate(over="ignore", invalid="ignore"):
        single = values.astype(np.float32, copy=False)
    usable = np.abs(single) <= LARGEST
    if not usable.all():
        at = tuple(int(i) for i in np.argwhere(~usable)[0])
        raise InputError(
            f"{where} is NaN, infinite or beyond {LARGEST:g} at index {at}: cut or repair the pinch"
        )
    return single


def check_force(where: str, values: NDArray[Any], unit: str) -> None:
    """Refuse forces that no taxel has in their unit: a wrong one hides the start of the motor.

    Parameters
    ----------
    where
        Named in messages: file and column.
    values
        As they are in the file.
    unit
        A key of ``FORCE_UNITS``.

    Raises
    ------
    InputError
        Values beyond ``FORCE_MOST``.
    """
    most = float(np.abs(values.astype(np.float64)).max(initial=0.0))
    if most * FORCE_UNITS[unit] > FORCE_MOST:
        others = "counts (10 bits over 3.3 V)" if unit == "V" else "V"
        raise InputError(
            f"{where} reaches {most:g} {unit}, and a taxel has at most {FORCE_MOST:g} V: say "
            f"force_unit {others}, convert force to volts, or leave it out"
        )


def joined(parts: list[NDArray[Any]]) -> NDArray[Any]:
    """Columns side by side in one type: float32 as soon as one of them is float."""
    kinds = {p.dtype.type for p in parts}
    dtype: type[Any] = np.int16
    if np.float32 in kinds:
        dtype = np.float32
    elif np.int32 in kinds:
        dtype = np.int32
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
    """Columns of imported data: vibration, then force (index, thumb), then strip.

    Parameters
    ----------
    settings
        What is said of the sensor.
    sensors
        2 are those of index finger and thumb. One piezo is the index finger's; any other
        sensor that is alone belongs to no finger.
    scale
        Units per raw step, where the unit alone does not say it.
    axes
        Columns of each sensor.
    force, strip
        Whether 2 x 6 force and 2 strip columns follow.

    Raises
    ------
    InputError
        A vector of which no axis is said to stand for it, or one that it does not have.
    """
    sensor, axis = settings.sensor, settings.axis
    if axes > 1 and (axis is None or axis >= axes):
        raise InputError(
            f"the {sensor} has {axes} axes and its axis is {'not said' if axis is None else axis}: "
            f"say which one contacts are looked for in, axis 0 to {axes - 1}"
        )
    step, zero = UNITS[settings.unit]
    step = step if scale is None else scale
    unit = "V" if settings.unit == "counts" else settings.unit
    alone = sensors == 1 and sensor is not VibrationSensor.PIEZO
    channels = [
        Channel(
            sensor if finger is None else f"{sensor}_{finger_name(finger)}",
            ChannelKind.VIBRATION,
            finger,
            unit,
            step,
            zero,
            sensor=sensor,
            smoothing_alpha=settings.smoothing_alpha,
            axes=axes,
            axis=(axis or 0) if axes > 1 else 0,
        )
        for finger in ([None] if alone else list(Finger)[:sensors])
    ]
    if force:
        volts = FORCE_UNITS[settings.force_unit]
        channels += [
            Channel(f"force_{finger_name(f)}_{k}", ChannelKind.FORCE, f, "V", volts, 0.0, taxel=k)
            for f in Finger
            for k in range(TAXELS)
        ]
    if strip:
        channels += [Channel(f"strip_{finger_name(f)}", ChannelKind.STRIP, f, "") for f in Finger]
    return Layout(tuple(channels), settings.rate)
