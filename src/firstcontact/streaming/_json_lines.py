"""Events for other programs: a JSON object a line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TextIO

from firstcontact.device import Descriptor, Health
from firstcontact.streaming import _event_json as event_json
from firstcontact.streaming._lines import write_now
from firstcontact.streaming._sink import Update


class JsonLinesSink:
    """Writes what happens as lines of JSON, as soon as it is told.

    The fields are those of ``docs/reference/live-output.md``.

    Parameters
    ----------
    stream
        Where to; stays open.
    """

    name = "json"
    every = 0.1

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._link = event_json.of_link(Health(connected=True))
        self._failed: Mapping[str, str] = {}

    def open(self, descriptor: Descriptor) -> None:
        """Write what sends."""
        self._write([event_json.of_descriptor(descriptor)])

    def take(self, update: Update) -> None:
        """Write markers and events, the link's counts where they changed, and what failed.

        Raises
        ------
        OSError
            Who listened is gone (BrokenPipeError), or it cannot be written.
        """
        link = event_json.of_link(update.health)
        trees = [link] if link != self._link else []
        self._link = link
        trees += [event_json.of_failure(*f) for f in update.failed.items() - self._failed.items()]
        self._failed = update.failed
        trees += [event_json.of_marker(m) for a in update.arrivals for m in a.markers]
        trees += [event_json.of_event(event) for event in update.events]
        if trees:
            self._write(trees)

    def close(self) -> None:
        """Nothing is held back."""

    def _write(self, trees: Sequence[Mapping[str, Any]]) -> None:
        write_now(self._stream, "".join(event_json.text(tree) + "\n" for tree in trees))
