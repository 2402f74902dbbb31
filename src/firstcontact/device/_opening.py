"""All kinds of sources by name, and one way in. A new one is one file and one entry here."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from firstcontact.core import InputError, Registry

if TYPE_CHECKING:
    from firstcontact.device._source import Source

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class SourceOptions:
    """What else a person may say of a source.

    Parameters
    ----------
    speed
        Times real time, where it can be chosen.
    condition, seed
        Of the twin.
    objects
        What the twin picks up: the name of a set or of one object.
    """

    speed: float = 1.0
    condition: str = "paper-rig"
    seed: int = 0
    objects: str = "paper"

    def check_own_speed(self, device: str) -> None:
        """Refuse another speed for what has its own; ``device`` is what has it, in words.

        Raises
        ------
        InputError
            A speed is asked of it.
        """
        if self.speed != 1.0:
            raise InputError(f"--speed is {self.speed:g}, but {device} has its own: leave it out")


@dataclass(frozen=True, slots=True)
class SourceKind:
    """A kind of sources: which devices are of it, and how one is opened.

    Parameters
    ----------
    name
        Under which it is registered.
    title
        How a device of this kind is named, as help says it: "a serial port".
    make
        From what a person typed and the options to a source that is not entered yet.
    takes
        Whether what a person typed is of this kind; without it, all that begins with the
        name and a colon is.
    recorded
        Whether it gives what has happened already.
    simulated
        Whether its hand is no real one: it takes orders, and its time may run faster.
    is_port
        Whether what a person types is the path of a port.
    origin
        What its recordings will say of where they come from, where that is known before.
    shore_a
        Of an object that a simulated hand knows by name. Raises InputError for others.
    discover
        What there is of it to open: the device as a person types it, and what it is.
    """

    name: str
    title: str
    make: Callable[[str, SourceOptions], Source]
    takes: Callable[[str], bool] | None = None
    recorded: bool = False
    simulated: bool = False
    is_port: bool = False
    origin: str = ""
    shore_a: Callable[[str], float] | None = None
    discover: Callable[[], Iterable[tuple[str, str]]] | None = None

    def accepts(self, device: str) -> bool:
        """Whether this is a device of this kind."""
        return device.startswith(f"{self.name}:") if self.takes is None else self.takes(device)


def _in(module: str, function: str) -> Callable[..., Any]:
    """A function of this room, whose module is imported when it is called."""

    def called(*arguments: Any) -> Any:
        return getattr(import_module(f"firstcontact.device.{module}"), function)(*arguments)

    return called


_OURS = (
    SourceKind(
        "serial",
        "a serial port",
        _in("_serial_source", "from_port"),
        takes=lambda device: True,
        is_port=True,
    ),
    SourceKind(
        "twin",
        '"twin" for the simulated hand',
        _in("_twin_source", "from_name"),
        takes=lambda device: device == "twin",
        simulated=True,
        origin="twin",
        shore_a=_in("_twin_source", "shore_a"),
    ),
    SourceKind(
        "recording",
        "a recording to replay",
        _in("_replay", "from_path"),
        takes=lambda device: Path(device).suffix == ".mcap",
        recorded=True,
    ),
    SourceKind(
        "audio",
        '"audio" or audio:NAME for a sound input (audio:NAME/2 for two channels)',
        _in("_audio_source", "from_name"),
        takes=lambda device: device.partition(":")[0] in ("audio", "audio/2"),
        origin="real",
        discover=_in("_audio_source", "discover"),
    ),
    SourceKind(
        "csv",
        "csv:PORT for a board that prints numbers in lines (csv:PORT@BAUD#COLUMN,COLUMN)",
        _in("_csv_source", "from_name"),
        origin="real",
    ),
    SourceKind(
        "lsl",
        "lsl:NAME for a stream of the Lab Streaming Layer (lsl:NAME#CHANNEL,CHANNEL)",
        _in("_lsl_source", "from_name"),
    ),
)
#: What no other kind takes is of the default.
SOURCES: Registry[SourceKind] = Registry(
    "source",
    "firstcontact.sources",
    {
        **{kind.name: kind for kind in _OURS},
    },
    base="firstcontact.device._opening:SourceKind",
    instances=True,
)


def source_kind(device: str) -> SourceKind:
    """The kind of a device.

    Plug-ins are imported only where the device begins with their name and a colon, or where no
    kind of this package takes it and it is no port that is there.

    Raises
    ------
    InputError
        It is of a plug-in that cannot be loaded.
    """
    named, colon, _ = device.partition(":")
    if colon and named in (*SOURCES.names, *SOURCES.failed) and SOURCES.find(named).takes is None:
        return SOURCES.find(named)
    own = [SOURCES[name] for name in SOURCES.own if name != SOURCES.default]
    kind = next((kind for kind in own if kind.accepts(device)), None)
    if kind is None and not Path(device).is_char_device():
        kind = _of_plugin(device)
    return kind or SOURCES[SOURCES.default]


def _of_plugin(device: str) -> SourceKind | None:
    for name in SOURCES:
        if name not in SOURCES.own:
            with SOURCES.calling(name):
                if SOURCES[name].accepts(device):
                    return SOURCES[name]
    return None


def list_devices() -> list[tuple[str, str]]:
    """What there is to open of kinds that can be looked for: as a person types it, what it is."""
    devices: list[tuple[str, str]] = []
    for name, kind in SOURCES.items():
        if kind.discover is not None:
            with SOURCES.calling(name):
                devices += kind.discover()
    return devices


def open_source(
    device: str,
    *,
    speed: float = 1.0,
    condition: str = "paper-rig",
    seed: int = 0,
    objects: str = "paper",
) -> Source:
    """A source that is not entered yet.

    Parameters
    ----------
    device
        "twin", a recording (a path that ends in .mcap), a serial port, or what a plug-in takes.
    speed, condition, seed, objects
        See :class:`SourceOptions`.

    Raises
    ------
    InputError
        A recording that cannot be replayed, another speed for a real device, or a kind that
        needs something that is missing.
    """
    _log.info("opening %s", device)
    kind = source_kind(device)
    with SOURCES.calling(kind.name):
        source = kind.make(device, SourceOptions(speed, condition, seed, objects))
        if not hasattr(source, "__enter__"):
            raise TypeError(f"{type(source).__name__} is no source")
    return source
