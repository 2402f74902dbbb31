"""The twin as a source: its device is plugged in when it is opened, and goes with it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Self

from firstcontact.core import FINGERTIP_RATE, require_modules
from firstcontact.device._opening import SourceOptions
from firstcontact.device._serial_source import SerialSource
from firstcontact.device._twin_device import TwinDevice
from firstcontact.twin import LATENCY

#: Faster than real time the twin is ahead of its reader by so much and what is on the line, s.
AHEAD = 0.25


class TwinSource(SerialSource):
    """A :class:`SerialSource` on the port of a :class:`TwinDevice` of its own.

    Parameters
    ----------
    condition, objects, seed, speed, latency
        As of the device.
    """

    def __init__(
        self,
        condition: str = "paper-rig",
        objects: Sequence[str] | None = None,
        seed: int = 0,
        speed: float = 1.0,
        latency: float = LATENCY,
    ) -> None:
        super().__init__("twin")
        self._make = partial(TwinDevice, condition, objects, seed, speed, latency)
        self.device: TwinDevice | None = None
        #: Multiple of real time.
        self.speed = speed
        if speed > 1.0:  # then the device waits: an order is not to come long after its samples
            self.most = round(AHEAD * FINGERTIP_RATE)

    @property
    def name(self) -> str:
        """What a person calls it."""
        return "twin"

    def __enter__(self) -> Self:
        self.device = self._make()
        self.port = self.device.port
        try:
            return super().__enter__()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close the port, then the device."""
        try:
            super().close()
        finally:
            if self.device is not None:
                self.device.close()


def from_name(name: str, options: SourceOptions) -> TwinSource:
    """The twin as a person asked for it; InputError without its extra."""
    require_modules("twin", "numba")
    return TwinSource(options.condition, [options.objects], options.seed, options.speed)


def shore_a(name: str) -> float:
    """Of an object that the twin has; InputError for others, and without its extra."""
    require_modules("twin", "numba")
    from firstcontact.twin import thing_named

    return thing_named(name).shore_a
