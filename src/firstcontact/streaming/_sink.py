"""Outputs of a live session: viewers and other programs."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol, TextIO

from firstcontact.device import Arrival, Descriptor, Health, RecorderStatus
from firstcontact.streaming._events import Event
from firstcontact.streaming._hand_requests import Ask


@dataclass(frozen=True, slots=True, eq=False)
class Update:
    """Samples and events since the last update, and the state of the live session."""

    arrivals: tuple[Arrival, ...] = ()
    events: tuple[Event, ...] = ()
    health: Health = field(default_factory=Health)
    recording: RecorderStatus = field(default_factory=RecorderStatus)
    ledger: Mapping[str, float] = field(default_factory=dict)
    failed: Mapping[str, str] = field(default_factory=dict)


class Sink(Protocol):
    """Output of a live session. It takes updates in a separate thread.

    A sink may be slow or fail. Its queue is bounded: updates that do not fit are dropped and
    counted, and the session continues. A sink for other programs sets ``is_prompt = True`` and gets
    each event immediately. Other sinks may get the events up to 50 ms late.
    """

    @property
    def name(self) -> str:
        """Name under which dropped updates are reported."""

    @property
    def every(self) -> float:
        """Longest time that samples may wait before the sink gets them, s."""

    def open(self, descriptor: Descriptor) -> None:
        """Start the output. Called once, before the first update."""

    def take(self, update: Update) -> None:
        """Process an update."""

    def close(self) -> None:
        """Close the output. Always called once."""


class Controls(Protocol):
    """Methods with which viewers control a live session, callable from any thread."""

    def start_recording(self) -> Path:
        """Begin a recording. Raise InputError if one is running or cannot be created."""

    def stop_recording(self) -> None:
        """Close the recording, if one is running."""

    def mark(self, text: str) -> None:
        """Attach a marker to the next sample."""

    def hand_asks(self) -> tuple[Ask, ...]:
        """Return the possible requests to the hand; empty without a hand."""

    def ask_hand(self, ask: Ask, by: str) -> None:
        """Send a request to the hand. Raise InputError if it is not possible now."""

    def hand_gone(self, by: str) -> None:
        """Open the hand if the viewer ``by``, now disconnected, had closed it."""

    def new_object(self) -> None:
        """Begin another object. From now on, only pinches of the new object are pooled."""

    @property
    def uses_shape(self) -> bool:
        """True if the model uses the shape of the object."""

    def set_shape(self, text: str) -> str:
        """Set the shape of the next objects. Return the shape in words, or raise InputError."""


def write_now(stream: TextIO, text: str) -> None:
    """Write text to a stream and flush the stream."""
    try:
        stream.write(text)
        stream.flush()
    except OSError:
        with suppress(OSError, ValueError):
            null = os.open(os.devnull, os.O_WRONLY)
            os.dup2(null, stream.fileno())
            os.close(null)
        raise
