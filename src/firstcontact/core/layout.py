"""What the columns of a sample are: the sensor layout."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from enum import IntEnum, StrEnum
from typing import Annotated, Any, Literal

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from firstcontact.core.records import Name

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
#: A rate that a sensor of this kind can have, Hz.
Rate = Annotated[float, Meta(ge=1.0, le=1e7)]
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


class ChannelKind(StrEnum):
    """What a channel measures."""

    PIEZO = "piezo"
    FORCE = "force"
    STRIP = "strip"


@dataclass(frozen=True, slots=True)
class Channel:
    """One column of a sample.

    ``physical = (raw - offset) * scale``, in ``unit``.

    Raises
    ------
    ValueError
        A scale or offset that no sensor has.
    """

    name: Name
    kind: ChannelKind
    finger: Finger
    unit: Name
    scale: float = 1.0
    offset: Annotated[float, Meta(ge=-LARGEST_OFFSET, le=LARGEST_OFFSET)] = 0.0
    taxel: Annotated[int, Meta(ge=0, lt=MOST_CHANNELS)] | None = None

    def __post_init__(self) -> None:
        if not SCALES[0] <= abs(self.scale) <= SCALES[1]:
            raise ValueError(f"scale is {self.scale:g}")


@dataclass(frozen=True, slots=True)
class Layout:
    """The columns of a sample, their rate and what was done to them.

    Parameters
    ----------
    channels
        The columns in their order.
    rate
        Mean sampling rate, Hz.
    smoothing_alpha
        Coefficient of the exponential smoothing already applied to the piezo
        channels (1 = none).
    """

    channels: Annotated[tuple[Channel, ...], Meta(max_length=MOST_CHANNELS)]
    rate: Rate
    smoothing_alpha: Annotated[float, Meta(gt=0.0, le=1.0)] = 1.0

    def columns(self, kind: ChannelKind, finger: Finger | None = None) -> tuple[int, ...]:
        """Column numbers of a kind of channel, of one finger or of both."""
        return tuple(
            i
            for i, c in enumerate(self.channels)
            if c.kind is kind and (finger is None or c.finger is finger)
        )

    @property
    def piezo_fingers(self) -> tuple[Finger, ...]:
        """The fingers that have a piezo channel, in column order."""
        return tuple(c.finger for c in self.channels if c.kind is ChannelKind.PIEZO)

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
        """A JSON-ready form."""
        return asdict(self)

    @property
    def fault(self) -> str:
        """What keeps it from being used, "" where nothing does."""
        names = [c.name for c in self.channels]
        if not self.piezo_fingers:
            return "no piezo channel"
        for kind in (ChannelKind.PIEZO, ChannelKind.STRIP):
            if any(len(self.columns(kind, finger)) > 1 for finger in Finger):
                return f"two {kind} channels of one finger"
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
        chosen = [layout.channels[i] for i in columns]
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
    piezo = [Channel(f"piezo_{n}", ChannelKind.PIEZO, f, "V", volt, zero) for f, n in names.items()]
    force = [
        Channel(f"force_{n}_{k}", ChannelKind.FORCE, f, "V", volt, 0.0, k)
        for f, n in names.items()
        for k in range(TAXELS)
    ]
    strip = [Channel(f"strip_{n}", ChannelKind.STRIP, f, "") for f, n in names.items()]
    return Layout((*piezo, *force, *strip), FINGERTIP_RATE, FINGERTIP_SMOOTHING)
