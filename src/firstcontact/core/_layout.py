"""What the columns of a sample are: the sensor layout."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from enum import IntEnum, StrEnum
from itertools import accumulate
from typing import Annotated, Any, Literal

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from firstcontact.core._records import Name

#: Mean sampling rate of the published fingertip, Hz.
FINGERTIP_RATE = 4936.0
#: Coefficient of the exponential smoothing on the microcontroller.
FINGERTIP_SMOOTHING = 0.5
#: Taxels of one fingertip's 3 x 2 force array.
TAXELS = 6
#: The device sends filtered values with five fractional bits: 1/32 ADC count.
SUBCOUNTS = 32
ADC_COUNTS = 1024
ADC_VOLTS = 3.3
PIEZO_OFFSET_VOLTS = 1.65


#: Most channels, and highest number of a taxel: more than any hand has.
MOST_CHANNELS = 256
#: Most groups of slower channels.
MOST_GROUPS = 16
#: A rate that a sensor of this kind can have, Hz.
Rate = Annotated[float, Meta(ge=1.0, le=1e7)]
#: Coefficient of an exponential smoothing.
Alpha = Annotated[float, Meta(gt=0.0, le=1.0)]
#: Smallest and largest size of a channel's scale, and largest of its offset: far beyond any
#: sensor, and such that what is computed of them stays finite.
SCALES = (1e-15, 1e6)
LARGEST_OFFSET = 1e12


class Finger(IntEnum):
    """One of the two fingers of a pinch."""

    INDEX = 0
    THUMB = 1

    @property
    def other(self) -> Finger:
        """The finger on the opposite side."""
        return Finger(1 - self)


def finger_name(finger: Finger | None) -> str:
    """As people read it; what belongs to no finger is "sensor"."""
    return "sensor" if finger is None else finger.name.lower()


class ChannelKind(StrEnum):
    """What a channel measures."""

    VIBRATION = "vibration"
    FORCE = "force"
    STRIP = "strip"

    @classmethod
    def _missing_(cls, value: object) -> ChannelKind | None:
        # Devices and recordings of version 1 say so.
        return cls.VIBRATION if value == "piezo" else None


class VibrationSensor(StrEnum):
    """What a vibration is measured with."""

    PIEZO = "piezo"
    ACCELEROMETER = "accelerometer"
    MICROPHONE = "microphone"
    HYDROPHONE = "hydrophone"


@dataclass(frozen=True, slots=True)
class Channel:
    """One column of a sample, or several beside each other: the axes of a vector.

    ``physical = (raw - offset) * scale``, in ``unit``.

    Parameters
    ----------
    finger
        Whose it is; None for a sensor that belongs to no finger.
    taxel
        Place in a force array.
    sensor
        What measures the vibration, by default a piezo; None for other kinds.
    smoothing_alpha
        Coefficient of the exponential smoothing already applied (1 = none).
    axes, axis
        Columns of a vector, and which of them stands for it in detectors and windows.

    Raises
    ------
    ValueError
        A scale or offset that no sensor has, an axis that is not there, or a vibration
        sensor that measures something else.
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
        if not SCALES[0] <= abs(self.scale) <= SCALES[1]:
            raise ValueError(f"scale is {self.scale:g}")
        if self.axis >= self.axes:
            raise ValueError(f"axis is {self.axis} of {self.axes}, counted from 0")
        if self.kind is ChannelKind.VIBRATION:
            object.__setattr__(self, "sensor", self.sensor or VibrationSensor.PIEZO)
        elif self.sensor is not None:
            raise ValueError(f"sensor is {self.sensor} of a {self.kind} channel")

    @property
    def column_names(self) -> tuple[str, ...]:
        """A name for each of its columns: its own, or with the axis behind it."""
        if self.axes == 1:
            return (self.name,)
        ends = "xyz" if self.axes <= len("xyz") else range(self.axes)
        return tuple(f"{self.name}_{end}" for end, _ in zip(ends, range(self.axes), strict=False))


@dataclass(frozen=True, slots=True)
class Group:
    """Slower channels beside the others, with a count and a rate of their own.

    Sample ``k`` was taken at ``k / layout.rate``, on the clock on which sample ``n`` of the
    layout that it belongs to was taken at ``n / rate``.
    """

    name: Name
    layout: Layout


@dataclass(frozen=True, slots=True)
class Layout:
    """The columns of a sample, their rate and what was done to them.

    Parameters
    ----------
    channels
        In the order of their columns.
    rate
        Mean sampling rate, Hz.
    smoothing_alpha
        Where given, that of all vibration channels, which it is passed on to (it is None
        afterwards): devices and recordings of version 1 say it once.
    groups
        Slower ones beside these channels; contacts are not looked for in them.

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
        """The channel of each column, shape (columns of a sample,)."""
        return tuple(c for c in self.channels for _ in range(c.axes))

    @property
    def column_names(self) -> tuple[str, ...]:
        """A name for each column."""
        return tuple(name for c in self.channels for name in c.column_names)

    @property
    def width(self) -> int:
        """Columns of a sample."""
        return sum(c.axes for c in self.channels)

    def columns(self, kind: ChannelKind, *fingers: Finger | None) -> tuple[int, ...]:
        """Column numbers of a kind of channel, with ``fingers`` only theirs (None: of none).

        One a channel: of a vector its :attr:`~Channel.axis`.
        """
        starts = accumulate((c.axes for c in self.channels), initial=0)
        return tuple(
            start + c.axis
            for start, c in zip(starts, self.channels, strict=False)
            if c.kind is kind and (not fingers or c.finger in fingers)
        )

    @property
    def vibration(self) -> tuple[Channel, ...]:
        """The vibration channels, in column order."""
        return tuple(c for c in self.channels if c.kind is ChannelKind.VIBRATION)

    @property
    def vibration_fingers(self) -> tuple[Finger | None, ...]:
        """Whose the vibration channels are, in column order; None stands for no finger."""
        return tuple(c.finger for c in self.vibration)

    @property
    def smoothing(self) -> str:
        """What was done to its vibration channels, for people."""
        alphas = dict.fromkeys((c.sensor, c.smoothing_alpha) for c in self.vibration)
        return ", ".join(f"{sensor} smoothing alpha {alpha:g}" for sensor, alpha in alphas)

    @property
    def has_force(self) -> bool:
        """Whether any force channel is there."""
        return any(c.kind is ChannelKind.FORCE for c in self.channels)

    @property
    def has_strip(self) -> bool:
        """Whether any strip channel is there."""
        return any(c.kind is ChannelKind.STRIP for c in self.channels)

    def physical(self, data: NDArray[Any], columns: tuple[int, ...]) -> NDArray[np.float64]:
        """Columns of raw samples in their physical units.

        Parameters
        ----------
        data
            Raw samples, shape (samples, channels).
        columns
            Which columns.

        Returns
        -------
        ndarray
            Shape (samples, len(columns)).
        """
        return Physical(self, columns)(data)

    def to_json(self) -> dict[str, Any]:
        """A JSON-ready form, without what is as by default."""
        channels = [
            {f.name: v for f in fields(c) if (v := getattr(c, f.name)) != f.default}
            for c in self.channels
        ]
        groups = [{"name": g.name, "layout": g.layout.to_json()} for g in self.groups]
        tree = {"channels": channels, "rate": self.rate}
        return {**tree, "groups": groups} if groups else tree

    @property
    def fault(self) -> str:
        """What keeps it from being used, "" where nothing does."""
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
            its = group.layout
            if not 0 < its.width <= MOST_CHANNELS or its.groups or its.rate > self.rate:
                return f"a group {group.name!r} that is empty, too large, nested or the faster"
            names += its.column_names
        if len({g.name for g in self.groups}) < len(self.groups):
            return "two groups of one name"
        return "two channels of one name" if len(set(names)) < len(names) else ""


class Physical:
    """Takes columns of raw samples to their physical units; made once for many blocks.

    Parameters
    ----------
    layout
        Whose columns.
    columns
        Which.
    order
        In memory: "F" has a column's samples side by side, "C" a sample's columns. Sums over
        samples round differently in the two.
    """

    def __init__(
        self, layout: Layout, columns: tuple[int, ...], order: Literal["C", "F"] = "F"
    ) -> None:
        every = layout.column_channels
        chosen = [every[i] for i in columns]
        first, n = (columns[0], len(columns)) if columns else (0, 0)
        beside = columns == tuple(range(first, first + n))
        # Columns that lie side by side need not be gathered.
        self._columns = slice(first, first + n) if beside else np.array(columns, dtype=np.intp)
        self._order: Literal["C", "F"] = order
        self._offset = np.array([c.offset for c in chosen], dtype=np.float64)
        self._scale = np.array([c.scale for c in chosen], dtype=np.float64)

    def __call__(self, data: NDArray[Any]) -> NDArray[np.float64]:
        """Raw samples (samples, channels) to (samples, columns)."""
        raw: NDArray[np.float64] = data[:, self._columns].astype(np.float64, order=self._order)
        raw -= self._offset
        raw *= self._scale
        return raw


def fingertip_layout() -> Layout:
    """The 16 channels of the published hand: int16, 1/32 ADC count.

    Two piezo channels (V around the 1.65 V offset), two 3 x 2 force arrays
    (V over the divider), two strips (0 open, 1 closed).
    """
    volt = ADC_VOLTS / (ADC_COUNTS * SUBCOUNTS)
    zero = PIEZO_OFFSET_VOLTS / volt
    names = {Finger.INDEX: "index", Finger.THUMB: "thumb"}
    piezo = [
        Channel(f"piezo_{n}", ChannelKind.VIBRATION, f, "V", volt, zero) for f, n in names.items()
    ]
    force = [
        Channel(f"force_{n}_{k}", ChannelKind.FORCE, f, "V", volt, 0.0, k)
        for f, n in names.items()
        for k in range(TAXELS)
    ]
    strip = [Channel(f"strip_{n}", ChannelKind.STRIP, f, "") for f, n in names.items()]
    return Layout((*piezo, *force, *strip), FINGERTIP_RATE, FINGERTIP_SMOOTHING)
