"""Events for other programs: a JSON object a line."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any, TextIO

from firstcontact.device import Descriptor, Health
from firstcontact.live import told
from firstcontact.live.sink import Update


class JsonLinesSink:
    """Writes what happens as lines of JSON, as soon as it is told.

    The fields are those of ``docs/reference/live-output.md``.

    Parameters
    ----------
    stream
        Where to; stays open.
    """

    name = "json"

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._link = told.of_link(Health(connected=True))

    def open(self, descriptor: Descriptor) -> None:
        """Write what sends."""
        self._write([told.of_descriptor(descriptor)])

    def take(self, update: Update) -> None:
        """Write markers and events, and the link's counts where they changed.

        Raises
        ------
        BrokenPipeError
            Who listened is gone.
        """
        link = told.of_link(update.health)
        trees = [link] if link != self._link else []
        self._link = link
        trees += [told.of_marker(m) for a in update.arrivals for m in a.markers]
        trees += [told.of_event(event) for event in update.events]
        if trees:
            self._write(trees)

    def close(self) -> None:
        """Nothing is held back."""

    def _write(self, trees: Sequence[Mapping[str, Any]]) -> None:
        try:
            self._stream.write("".join(told.text(tree) + "\n" for tree in trees))
            self._stream.flush()
        except BrokenPipeError:
            self._give_up()
            raise

    def _give_up(self) -> None:
        # What waits in the stream would raise again when the program ends.
        with suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)
