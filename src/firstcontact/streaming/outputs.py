"""Registry of the outputs of a live session. To add one, write one file and add one line here."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from firstcontact.core import ArgumentError, Registry

if TYPE_CHECKING:
    from firstcontact.streaming._sinks import Sink
    from firstcontact.streaming.session import LiveSession


@dataclass(frozen=True, slots=True)
class OutputOptions:
    """Options of a live session that concern outputs, such as ports and tokens."""

    #: Address and TCP port of the page, and the token of its viewers on other machines.
    address: str = "127.0.0.1"
    port: int = 8765
    token: str | None = None
    foxglove_address: str = "127.0.0.1:8766"


@dataclass(frozen=True, slots=True)
class OutputKind:
    """Kind of output, such as "page": its name, and how to make its sink.

    The module of an output is imported before the source opens. It raises InputError if a package
    that it needs is not installed.

    Parameters
    ----------
    name
        Name in the registry :data:`OUTPUTS`.
    make
        Function of a live session and the options that returns a sink.
    to_stdout
        True if the output writes to standard output, instead of the text.
    """

    name: str
    make: Callable[[LiveSession, OutputOptions], Sink]
    to_stdout: bool = False


OUTPUTS: Registry[OutputKind] = Registry(
    "output",
    "firstcontact.outputs",
    {
        "text": "firstcontact.streaming.text:TEXT",
        "json": "firstcontact.streaming.json_lines:JSON",
        "lsl": "firstcontact.streaming.lsl:LSL",
        "foxglove": "firstcontact.streaming.foxglove:FOXGLOVE",
        "page": "firstcontact.streaming.page.sink:PAGE",
    },
    default="text",
    base="firstcontact.streaming.outputs:OutputKind",
    instances=True,
)


def find_outputs(names: Iterable[str]) -> list[OutputKind]:
    """Return the outputs with these names, and also "text" unless one writes to standard output.

    This imports the modules of the outputs, which may take long. Raise InputError for an unknown
    name, or if two outputs write to standard output.
    """
    kinds = [OUTPUTS.find(name) for name in dict.fromkeys(names)]
    writers = [kind.name for kind in kinds if kind.to_stdout]
    if len(writers) > 1:
        raise ArgumentError(
            f"the outputs {' and '.join(writers)} write to standard output: choose one of them",
            parameter="output",
        )
    return kinds if writers else [OUTPUTS[OUTPUTS.default], *kinds]


def make_sinks(
    kinds: Sequence[OutputKind], session: LiveSession, options: OutputOptions
) -> list[Sink]:
    """Return the sinks of a live session, which are not open yet."""
    from firstcontact.streaming._sinks import Sink

    sinks = []
    for kind in kinds:
        with OUTPUTS.convert_errors(kind.name):
            sink = kind.make(session, options)
            if not isinstance(sink, Sink):
                raise TypeError(f"{type(sink).__name__} is not a sink")
        sinks.append(sink)
    return sinks
