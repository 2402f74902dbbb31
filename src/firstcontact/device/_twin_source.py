"""Source for the twin. Opening the source creates the twin's device, and closing removes it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Self

from firstcontact.core import FINGERTIP_RATE, kernels
from firstcontact.device._opening import SourceOptions
from firstcontact.device._serial_source import SerialSource
from firstcontact.device._twin_device import TwinDevice
from firstcontact.twin import LATENCY

#: Largest amount of received samples that wait for the reader, s, if the twin is faster than real
#: time. Data on the line are not included.
AHEAD = 0.25


class TwinSource(SerialSource):
    """:class:`SerialSource` that creates a :class:`TwinDevice` and opens its port."""

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
        #: Condition and random seed of the simulated hand.
        self.twin_hand = condition, seed
        if (
            speed > 1.0
        ):  # the device then waits for the reader, so that orders take effect without a long delay
            self.most = round(AHEAD * FINGERTIP_RATE)

    @property
    def name(self) -> str:
        """Name that is shown to users."""
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
    """Return the twin with the user's options. Raise InputError if it cannot run here."""
    kernels()
    return TwinSource(options.condition, [options.objects], options.seed, options.speed)


def shore_a(name: str) -> float:
    """Return the Shore A of an object of the twin."""
    from firstcontact.twin import find_object

    return find_object(name).shore_a
