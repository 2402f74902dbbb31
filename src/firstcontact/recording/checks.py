"""What every importer asks of signals, rates and layouts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Channel, ChannelKind, Finger, InputError, Layout
from firstcontact.core.layout import (
    ADC_COUNTS,
    ADC_VOLTS,
    FINGERTIP_RATE,
    FINGERTIP_SMOOTHING,
    PIEZO_OFFSET_VOLTS,
    TAXELS,
)
from firstcontact.recording.header import SOURCES
from firstcontact.recording.quoting import shown, text_of
from firstcontact.recording.samples import LARGEST

#: What holds for all pinches of a file; the first two must be given.
SETTINGS = ("sample_rate_hz", "piezo_unit", "smoothing_alpha", "source")
#: Slowest rate at which 15 ms of a contact still say something, Hz.
LOWEST_RATE = 2_000.0
#: Faster than any sensor of this kind: most likely a slip of unit, Hz.
HIGHEST_RATE = 1_000_000.0
#: Units of a piezo channel: scale and offset of ``(raw - offset) * scale``.
PIEZO_UNITS = {
    "V": (1.0, 0.0),
    "counts": (ADC_VOLTS / ADC_COUNTS, PIEZO_OFFSET_VOLTS * ADC_COUNTS / ADC_VOLTS),
    "full scale": (1.0, 0.0),
}


def check_rate(where: str, rate: Any) -> float:
    """The rate, if a sensor can have it.

    Raises
    ------
    InputError
        Not a number, or outside 2 kHz to 1 MHz.
    """
    try:
        # The imaginary part of a complex one would be dropped with a warning.
        value = math.nan if np.iscomplexobj(rate) else float(rate)
    except (TypeError, ValueError, OverflowError):
        value = math.nan
    if not LOWEST_RATE <= value <= HIGHEST_RATE:
        raise InputError(
            f"{where} is {shown(rate)} and must be from {LOWEST_RATE:g} to {HIGHEST_RATE:g}: "
            "give samples a second, recorded at 2 kHz or faster"
        )
    return value


@dataclass(frozen=True, slots=True)
class Settings:
    """What holds for all pinches of a stranger's file."""

    rate: float
    unit: str
    smoothing_alpha: float
    source: str  # "unknown" where nothing says it

    @property
    def notes(self) -> list[str]:
        """What a reader of results must know of these settings, one sentence each."""
        usual = self.smoothing_alpha == FINGERTIP_SMOOTHING and self.rate == FINGERTIP_RATE
        if self.smoothing_alpha == 1.0 or usual:
            return []
        return [
            f"the piezo came smoothed (alpha {self.smoothing_alpha:g} at {self.rate:g} Hz) and is "
            f"not smoothed again, so it differs from the device's {FINGERTIP_SMOOTHING:g} at "
            f"{FINGERTIP_RATE:g} Hz"
        ]


def read_settings(where: str, given: Mapping[str, Any]) -> Settings:
    """What a file says of itself, under the names of :data:`SETTINGS`.

    Raises
    ------
    InputError
        ``sample_rate_hz`` or ``piezo_unit`` is missing, or a value is impossible.
    """
    for name in ("sample_rate_hz", "piezo_unit"):
        if name not in given:
            raise InputError(f"{where} does not say {name}: add it")
    rate = check_rate(f"{where}: sample_rate_hz", given["sample_rate_hz"])
    unit = text_of(given["piezo_unit"])
    if unit not in PIEZO_UNITS:
        raise InputError(
            f"{where}: piezo_unit is {shown(unit)} and must be one of {', '.join(PIEZO_UNITS)}"
        )
    alpha = text_of(given.get("smoothing_alpha", "1"))
    try:
        smoothing = float(alpha)
    except ValueError:
        smoothing = math.nan
    if not 0 < smoothing <= 1:
        raise InputError(
            f"{where}: smoothing_alpha is {shown(alpha)} and must be above 0 and at most 1 "
            "(not smoothed)"
        )
    return Settings(rate, unit, smoothing, check_source(where, given.get("source", "unknown")))


def check_source(where: str, said: Any) -> str:
    """What a file says it comes from, if recordings have a word for it.

    Raises
    ------
    InputError
        It is none of :data:`firstcontact.recording.header.SOURCES`.
    """
    source = text_of(said)
    if source not in SOURCES:
        raise InputError(
            f"{where}: source is {shown(source)} and must be one of {', '.join(SOURCES)}"
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
    rate: float,
    *,
    piezos: int,
    unit: str,
    scale: float | None = None,
    force: bool = False,
    strip: bool = False,
    smoothing_alpha: float = 1.0,
) -> Layout:
    """Columns of imported data: piezo, then force (index, thumb), then strip.

    Parameters
    ----------
    rate
        Hz.
    piezos
        1 (the index finger's) or 2.
    unit
        One of :data:`PIEZO_UNITS`.
    scale
        Units per raw step, where the unit alone does not say it.
    force, strip
        Whether 2 x 6 force and 2 strip columns follow.
    smoothing_alpha
        What was already applied.
    """
    step, zero = PIEZO_UNITS[unit]
    step = step if scale is None else scale
    shown = "V" if unit == "counts" else unit
    names = {Finger.INDEX: "index", Finger.THUMB: "thumb"}
    channels = [
        Channel(f"piezo_{n}", ChannelKind.PIEZO, f, shown, step, zero)
        for f, n in list(names.items())[:piezos]
    ]
    if force:
        channels += [
            Channel(f"force_{n}_{k}", ChannelKind.FORCE, f, "", taxel=k)
            for f, n in names.items()
            for k in range(TAXELS)
        ]
    if strip:
        channels += [Channel(f"strip_{n}", ChannelKind.STRIP, f, "") for f, n in names.items()]
    return Layout(tuple(channels), rate, smoothing_alpha)
