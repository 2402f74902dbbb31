"""One way in: a source by the name that a person gives it."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from firstcontact.core import InputError
from firstcontact.device.source import Source


def open_source(
    name: str,
    *,
    speed: float = 1.0,
    condition: str = "paper-rig",
    seed: int = 0,
) -> Source:
    """A source that is not entered yet.

    Parameters
    ----------
    name
        "twin", a recording (a path that ends in .mcap), or a serial port.
    speed
        Times real time, of the twin or a recording.
    condition, seed
        Of the twin.

    Raises
    ------
    InputError
        A recording that cannot be replayed, another speed for a real device, or a
        twin without its extra.
    """
    if name == "twin":
        if find_spec("numba") is None:
            raise InputError(
                "the twin needs numba, which the base install leaves out: "
                "pip install 'firstcontact[twin]'"
            )
        from firstcontact.device.twin_source import TwinSource

        return TwinSource(condition, seed=seed, speed=speed)
    if Path(name).suffix == ".mcap":
        from firstcontact.device.replay import ReplaySource

        return ReplaySource(Path(name), speed)
    if speed != 1.0:
        raise InputError(f"--speed is {speed:g}, but a device on {name} has its own: leave it out")
    from firstcontact.device.serial_source import SerialSource

    return SerialSource(name)
