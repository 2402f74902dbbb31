"""Registry of source kinds, and the function that opens a source."""

from __future__ import annotations

import logging
import math
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from firstcontact.core import ArgumentError, Registry
from firstcontact.core.files import AnyPath, given_path

if TYPE_CHECKING:
    from firstcontact.device.source import Source

_log = logging.getLogger("firstcontact.device")

#: Least speed of a source, as a multiple of real time: 10 ms of samples take hours.
SLOWEST = 1e-6


def check_speed(speed: float, fastest: float = math.inf) -> None:
    if not SLOWEST <= speed <= fastest:
        raise ArgumentError(
            f"the speed is {speed:g}: give a number from {SLOWEST:g} to {fastest:g}",
            parameter="speed",
        )


@dataclass(frozen=True, slots=True)
class SourceOptions:
    """Options of :func:`firstcontact.open` besides the device's name."""

    speed: float = 1.0
    condition: str = "paper-rig"
    seed: int = 0
    objects: str = "paper"
    fault: str = ""

    def check_own_speed(self, device: str) -> None:
        """Raise ArgumentError if the user set ``speed``, for a device that has its own pace."""
        if self.speed != 1.0:
            raise ArgumentError(
                f"{device} has a fixed speed: leave the speed out", parameter="speed"
            )


@dataclass(frozen=True, slots=True)
class SourceKind:
    """Kind of source, such as "serial": the device names it accepts, and how to make a source.

    Parameters
    ----------
    name
        Name in the registry :data:`SOURCES`.
    title
        Words that describe the device name in help texts, such as "a serial port".
    make
        Function that makes a source, not open yet, from a device name and the options.
    takes
        Function that returns True for a device name of this kind. By default a device name must
        begin with the name of the kind and a colon.
    is_replay
        True if the source replays a recording.
    is_simulated
        True for a simulated hand. It obeys :meth:`Source.order` and can run faster than real time.
    is_port
        True if the device name is the path of a serial port.
    shore_a
        Function that returns the Shore A of an object of the simulated hand from its name; None for
        other kinds.
    discover
        Function that yields (name to open, description) of each available device; None if devices
        cannot be listed.
    """

    name: str
    title: str
    make: Callable[[str, SourceOptions], Source]
    takes: Callable[[str], bool] | None = None
    is_replay: bool = False
    is_simulated: bool = False
    is_port: bool = False
    shore_a: Callable[[str], float] | None = None
    discover: Callable[[], Iterable[tuple[str, str]]] | None = None

    def accepts(self, device: str) -> bool:
        """Return True if the device name ``device`` belongs to this kind."""
        return device.startswith(f"{self.name}:") if self.takes is None else self.takes(device)


def _lazy(module: str, function: str) -> Callable[..., Any]:
    """Return a function that imports ``module`` when it is called, and calls its ``function``."""

    def call(*arguments: Any) -> Any:
        return getattr(import_module(f"firstcontact.device.{module}"), function)(*arguments)

    return call


_BUILT_IN = (
    SourceKind(
        "serial",
        "a serial port",
        _lazy("serial_source", "from_port"),
        takes=lambda device: True,
        is_port=True,
    ),
    SourceKind(
        "twin",
        '"twin" for the simulated hand',
        _lazy("twin_source", "from_name"),
        takes=lambda device: device == "twin",
        is_simulated=True,
        shore_a=_lazy("twin_source", "shore_a"),
    ),
    SourceKind(
        "recording",
        "a recording to replay",
        _lazy("replay", "from_path"),
        takes=lambda device: Path(device).suffix == ".mcap",
        is_replay=True,
    ),
    SourceKind(
        "audio",
        '"audio" or audio:NAME for a sound input (audio:NAME/2 for two channels)',
        _lazy("audio_source", "from_name"),
        takes=lambda device: device.partition(":")[0] in ("audio", "audio/2"),
        discover=_lazy("audio_source", "discover"),
    ),
    SourceKind("tape", "tape:FILE.wav for a sound file", _lazy("tape_source", "from_name")),
    SourceKind(
        "csv",
        "csv:PORT for a board that prints numbers in lines (csv:PORT@BAUD=UNIT#COLUMN,COLUMN)",
        _lazy("csv_source", "from_name"),
    ),
    SourceKind(
        "lsl",
        "lsl:NAME for a stream of the Lab Streaming Layer (lsl:NAME#CHANNEL,CHANNEL)",
        _lazy("lsl_source", "from_name"),
    ),
)
#: Registry of source kinds. The default, "serial", accepts all names that no other kind accepts.
SOURCES: Registry[SourceKind] = Registry(
    "source",
    "firstcontact.sources",
    {kind.name: kind for kind in _BUILT_IN},
    base="firstcontact.device.opening:SourceKind",
    instances=True,
)


def source_kind(device: str) -> SourceKind:
    """Return the kind of source that accepts a device name. Try plug-ins last."""
    named, colon, _ = device.partition(":")
    if colon and named in (*SOURCES.names, *SOURCES.failed) and SOURCES.find(named).takes is None:
        return SOURCES.find(named)
    built_in = [SOURCES[name] for name in SOURCES.builtin_names if name != SOURCES.default]
    for kind in built_in:
        if kind.accepts(device):
            return kind
    if not Path(device).is_char_device():
        for name in SOURCES:
            if name not in SOURCES.builtin_names:
                with SOURCES.convert_errors(name):
                    if SOURCES[name].accepts(device):
                        return SOURCES[name]
    return SOURCES[SOURCES.default]


def list_devices() -> list[tuple[str, str]]:
    """Return (name to open, description) of each device that is available now.

    Kinds that cannot list their devices, such as "serial", are left out.
    """
    devices: list[tuple[str, str]] = []
    for name, kind in SOURCES.items():
        if kind.discover is not None:
            with SOURCES.convert_errors(name):
                devices += kind.discover()
    return devices


def open(
    device: AnyPath = "twin",
    *,
    speed: float = 1.0,
    condition: str = "paper-rig",
    seed: int = 0,
    objects: str = "paper",
    fault: str = "",
) -> Source:
    """Open a live source of samples. Use it in a ``with`` statement, which closes it.

    Parameters
    ----------
    device
        "twin" for the simulated hand, the name of a serial port, "audio" for the sound input,
        "lsl:NAME" for an LSL stream, "csv:PORT" for a serial port that sends lines of numbers, or
        the path of a recording (.mcap) to replay.
    speed
        Speed of the simulated hand or of a replay, as a multiple of real time.
    condition, seed
        Variation of the simulated hand ("paper-rig" or "everyday"), and its random seed.
    objects
        Objects that the simulated hand grasps: "paper", "household", or the name of one object.
    fault
        Defect of the simulated fingertips, from ``firstcontact.twin.faults.FAULTS``.

    Raises
    ------
    InputError
        The device does not exist, or does not accept these parameters.

    Examples
    --------
    >>> import firstcontact as fc
    >>> def received(source: fc.Source) -> int:
    ...     health: fc.Health = source.health
    ...     return health.samples
    >>> with fc.open("twin", speed=4.0) as source:
    ...     arrivals = source.read(5.0, least=100)
    ...     samples = received(source)
    >>> samples >= sum(len(arrival.block.data) for arrival in arrivals) > 0
    True
    """
    from firstcontact.device.source import Source

    given_path(device, "device")
    device = os.fspath(device)
    _log.info("opening %s", device)
    kind = source_kind(device)
    with SOURCES.convert_errors(kind.name):
        source = kind.make(device, SourceOptions(speed, condition, seed, objects, fault))
        if not isinstance(source, Source):
            raise TypeError(f"{type(source).__name__} is not a source: return a Source")
    return source


#: Name of :func:`open` in this room.
open_source = open
