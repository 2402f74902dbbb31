"""Sensor layout: the channels of a sample, their units and their rate."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from enum import IntEnum, StrEnum
from itertools import accumulate
from typing import Annotated, Any, Literal

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from firstcontact.core.given import given_choice
from firstcontact.core.records import Name

#: Mean sampling rate of the published fingertip, Hz.
FINGERTIP_RATE = 4936.0
#: Length of the signal after the first contact from which stiffness is predicted, s.
FINGERTIP_WINDOW = 0.015
#: Coefficient of the exponential smoothing on the microcontroller.
FINGERTIP_SMOOTHING = 0.5
#: Taxels of one fingertip's 3 x 2 force array.
TAXELS = 6
#: Fractional steps of one ADC count: the device sends filtered values in 1/32 count.
SUBCOUNTS = 32
ADC_COUNTS = 1024
ADC_VOLTS = 3.3
PIEZO_OFFSET_VOLTS = 1.65


#: Largest number of channels and highest taxel number: more than any hand has.
MOST_CHANNELS = 256
#: Most groups of slower channels.
MOST_GROUPS = 16
#: Sampling rate of a sensor, Hz.
Rate = Annotated[float, Meta(ge=1.0, le=1e7)]
#: Coefficient of an exponential smoothing.
Alpha = Annotated[float, Meta(gt=0.0, le=1.0)]
#: Smallest and largest scale of a channel, and its largest offset. They are far beyond any sensor
#: and keep results finite.
SCALES = (1e-15, 1e6)
LARGEST_OFFSET = 1e12


class Finger(IntEnum):
    """Finger of the hand that carries sensors: index finger (0) or thumb (1)."""

    INDEX = 0
    THUMB = 1

    @property
    def other(self) -> Finger:
        """The other finger: THUMB for INDEX, INDEX for THUMB."""
        return Finger(1 - self)


def finger_name(finger: Finger | None) -> str:
    """Return "index" or "thumb", or "sensor" if ``finger`` is None (a sensor of no finger)."""
    return "sensor" if finger is None else finger.name.lower()


def finger_words(finger: Finger | None) -> str:
    """Return the finger's name for messages: "index finger", "thumb", or "sensor"."""
    return "index finger" if finger is Finger.INDEX else finger_name(finger)


class ChannelKind(StrEnum):
    """Quantity that a channel measures: vibration, force, contact strip and others."""

    VIBRATION = "vibration"
    FORCE = "force"
    #: Copper strip that closes a circuit when its finger touches: 0 open, 1 closed.
    STRIP = "strip"
    POSITION = "position"

    @classmethod
    def _missing_(cls, value: object) -> ChannelKind | None:
        # Devices and recordings of version 1 use this name.
        return cls.VIBRATION if value == "piezo" else None


class VibrationSensor(StrEnum):
    """Type of a vibration sensor."""

    PIEZO = "piezo"
    ACCELEROMETER = "accelerometer"
    MICROPHONE = "microphone"
    HYDROPHONE = "hydrophone"


@dataclass(frozen=True, slots=True)
class Channel:
    """One sensor signal: a column of the samples, or adjacent columns for the axes of a vector.

    Its physical value, in ``unit``, is ``(raw - offset) * scale``.

    Parameters
    ----------
    name, kind, unit
        Name of the channel, quantity that it measures, and physical unit, such as "V".
    finger
        Finger that carries the sensor; None if it belongs to no finger.
    taxel
        Number of the taxel (force cell) in the finger's force array; None for other channels.
    sensor
        Type of vibration sensor, by default a piezo; None for channels of other kinds.
    smoothing_alpha
        Weight of the newest sample in the exponential smoothing that the device already applied; 1
        means no smoothing.
    axes, axis
        Number of columns (1 for a scalar signal), and number, from 0, of the one column that
        detectors and models use.

    Raises
    ------
    ValueError
        The scale is out of range, the axis does not exist, or a channel that is not a vibration has
        a vibration sensor.
    """

    name: Name
    kind: ChannelKind
    finger: Finger | None
    unit: Name
    scale: float = 1.0
    offset: Annotated[float, Meta(ge=-LARGEST_OFFSET, le=LARGEST_OFFSET)] = 0.0
    taxel: Annotated[int, Meta(ge=0, lt=MOST_CHANNELS)] | None = None
    sensor: VibrationSensor | None = None
    smoothing_alpha: Alpha = 1.0
    axes: Annotated[int, Meta(ge=1, le=MOST_CHANNELS)] = 1
    axis: Annotated[int, Meta(ge=0)] = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "kind", given_choice(ChannelKind, self.kind, "kind"))
        if self.finger is not None:
            object.__setattr__(self, "finger", given_choice(Finger, self.finger, "finger"))
        if not SCALES[0] <= abs(self.scale) <= SCALES[1]:
            raise ValueError(
                f"scale is {self.scale:g}: give {SCALES[0]:g} to {SCALES[1]:g}, with either sign"
            )
        if self.axis >= self.axes:
            raise ValueError(
                f"axis is {self.axis}: give a number below {self.axes}, the number of axes"
            )
        if self.kind is ChannelKind.VIBRATION:
            object.__setattr__(self, "sensor", self.sensor or VibrationSensor.PIEZO)
        elif self.sensor is not None:
            raise ValueError(
                f"sensor is {self.sensor}: leave it out, as this is a {self.kind} channel"
            )

    @property
    def column_names(self) -> tuple[str, ...]:
        """Name of each column: the channel's name, with the axis appended for a vector."""
        if self.axes == 1:
            return (self.name,)
        ends = "xyz" if self.axes <= len("xyz") else range(self.axes)
        return tuple(f"{self.name}_{end}" for end, _ in zip(ends, range(self.axes), strict=False))


@dataclass(frozen=True, slots=True)
class Group:
    """Group of channels with a lower sampling rate and sample numbers of their own.

    Sample ``k`` of the group was taken ``k / layout.rate`` s after the zero of the device's clock,
    and sample ``n`` of the main channels ``n / rate`` s after it.
    """

    name: Name
    layout: Layout


@dataclass(frozen=True, slots=True)
class Layout:
    """Meaning of the columns of samples (channels, units), and their sampling rate.

    Parameters
    ----------
    channels
        Channels in the order of the columns.
    rate
        Mean sampling rate, Hz.
    smoothing_alpha
        Smoothing of all vibration channels, for devices and recordings of version 1, which state
        one value for all channels. It is copied to the channels and then set to None.
    groups
        Groups of channels with a lower rate. Contact detectors do not use them.

    Examples
    --------
    >>> layout: Layout = fingertip_layout()
    >>> layout.width, layout.rate
    (16, 4936.0)
    >>> layout.columns(ChannelKind.VIBRATION, Finger.THUMB)
    (1,)
    """

    channels: Annotated[tuple[Channel, ...], Meta(max_length=MOST_CHANNELS)]
    rate: Rate
    smoothing_alpha: Alpha | None = None
    groups: Annotated[tuple[Group, ...], Meta(max_length=MOST_GROUPS)] = ()

    def __post_init__(self) -> None:
        if (alpha := self.smoothing_alpha) is not None:
            channels = tuple(
                replace(c, smoothing_alpha=alpha) if c.kind is ChannelKind.VIBRATION else c
                for c in self.channels
            )
            object.__setattr__(self, "channels", channels)
            object.__setattr__(self, "smoothing_alpha", None)

    @property
    def column_channels(self) -> tuple[Channel, ...]:
        """Channel of each column; a channel with several axes is repeated."""
        return tuple(c for c in self.channels for _ in range(c.axes))

    @property
    def column_names(self) -> tuple[str, ...]:
        """Name of each column, such as "piezo_index" or "accelerometer_thumb_x"."""
        return tuple(name for c in self.channels for name in c.column_names)

    @property
    def width(self) -> int:
        """Number of columns of a sample."""
        return sum(c.axes for c in self.channels)

    def columns(self, kind: ChannelKind, *fingers: Finger | None) -> tuple[int, ...]:
        """Return the column numbers of the channels of one kind, optionally of some fingers only.

        None in ``fingers`` selects channels that belong to no finger. For a channel with several
        axes, only the column of its :attr:`~Channel.axis` is returned.
        """
        starts = accumulate((c.axes for c in self.channels), initial=0)
        return tuple(
            start + c.axis
            for start, c in zip(starts, self.channels, strict=False)
            if c.kind is kind and (not fingers or c.finger in fingers)
        )

    @property
    def vibration(self) -> tuple[Channel, ...]:
        """Vibration channels in column order."""
        return tuple(c for c in self.channels if c.kind is ChannelKind.VIBRATION)

    @property
    def vibration_fingers(self) -> tuple[Finger | None, ...]:
        """Finger of each vibration channel, in column order; None if it belongs to no finger."""
        return tuple(c.finger for c in self.vibration)

    @property
    def vibration_unit(self) -> str:
        """Unit of the vibration channels, such as "V", or "V and m/s2" for several units."""
        return " and ".join(sorted({c.unit or "no unit" for c in self.vibration}))

    @property
    def smoothing(self) -> str:
        """Text about the smoothing of the vibration channels: "piezo smoothing alpha 0.5"."""
        alphas = dict.fromkeys((c.sensor, c.smoothing_alpha) for c in self.vibration)
        return ", ".join(f"{sensor} smoothing alpha {alpha:g}" for sensor, alpha in alphas)

    @property
    def has_strip(self) -> bool:
        """True if a channel is a contact strip, a switch that closes when a finger touches."""
        return any(c.kind is ChannelKind.STRIP for c in self.channels)

    def physical(self, data: NDArray[Any], columns: tuple[int, ...]) -> NDArray[np.float64]:
        """Convert columns of raw samples to physical units, shape (samples, len(columns)).

        ``data`` has the shape (samples, width). ``columns`` are the column numbers to convert.
        """
        return Physical(self, columns)(data)

    def to_json(self) -> dict[str, Any]:
        """Return the layout as dicts and lists for JSON, without default values."""
        channels = [
            {f.name: v for f in fields(c) if (v := getattr(c, f.name)) != f.default}
            for c in self.channels
        ]
        groups = [{"name": g.name, "layout": g.layout.to_json()} for g in self.groups]
        tree = {"channels": channels, "rate": self.rate}
        return {**tree, "groups": groups} if groups else tree

    @property
    def why_unusable(self) -> str:
        """Text that says why this layout cannot be used; "" if it can."""
        if not self.vibration:
            return "no vibration channel"
        if self.width > MOST_CHANNELS:
            return f"{self.width} columns, more than {MOST_CHANNELS}"
        for kind in (ChannelKind.VIBRATION, ChannelKind.STRIP):
            for finger in (*Finger, None):
                if len(self.columns(kind, finger)) > 1:
                    return f"two {kind} channels of {'no' if finger is None else 'one'} finger"
        names = [*self.column_names]
        for group in self.groups:
            inner = group.layout
            if not 0 < inner.width <= MOST_CHANNELS or inner.groups or inner.rate > self.rate:
                return f"a group {group.name!r} that is empty, too large, nested or too fast"
            names += inner.column_names
        if len({g.name for g in self.groups}) < len(self.groups):
            return "two groups with the same name"
        return "two channels with the same name" if len(set(names)) < len(names) else ""


class Physical:
    """Converter of raw samples to physical units, made once for many blocks of one layout.

    ``columns`` are the numbers of the columns to convert. ``order`` is NumPy's memory order of the
    result, "C" or "F". It affects how sums over samples are rounded.
    """

    def __init__(
        self, layout: Layout, columns: tuple[int, ...], order: Literal["C", "F"] = "F"
    ) -> None:
        all_channels = layout.column_channels
        chosen = [all_channels[i] for i in columns]
        first, n = (columns[0], len(columns)) if columns else (0, 0)
        is_adjacent = columns == tuple(range(first, first + n))
        # Adjacent columns need no copy.
        self._columns = slice(first, first + n) if is_adjacent else np.array(columns, dtype=np.intp)
        self._order: Literal["C", "F"] = order
        self._offset = np.array([c.offset for c in chosen], dtype=np.float64)
        self._scale = np.array([c.scale for c in chosen], dtype=np.float64)

    def __call__(self, data: NDArray[Any]) -> NDArray[np.float64]:
        """Convert raw samples (samples, channels) to physical units (samples, columns)."""
        raw: NDArray[np.float64] = data[:, self._columns].astype(np.float64, order=self._order)
        raw -= self._offset
        raw *= self._scale
        return raw


def fingertip_layout() -> Layout:
    """Return the layout of the published hand: 16 channels of int16, in 1/32 of an ADC count.

    The channels are two piezos (V, after subtracting the offset of 1.65 V), two 3 x 2 force arrays
    (V over each divider's resistor), and two contact strips (0 open, 1 closed).
    """
    volt = ADC_VOLTS / (ADC_COUNTS * SUBCOUNTS)
    zero = PIEZO_OFFSET_VOLTS / volt
    piezo = [
        Channel(f"piezo_{finger_name(f)}", ChannelKind.VIBRATION, f, "V", volt, zero)
        for f in Finger
    ]
    force = [
        Channel(f"force_{finger_name(f)}_{k}", ChannelKind.FORCE, f, "V", volt, 0.0, k)
        for f in Finger
        for k in range(TAXELS)
    ]
    strip = [Channel(f"strip_{finger_name(f)}", ChannelKind.STRIP, f, "") for f in Finger]
    return Layout((*piezo, *force, *strip), FINGERTIP_RATE, FINGERTIP_SMOOTHING)
