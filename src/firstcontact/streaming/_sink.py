"""Where what happens live goes: viewers, other programs, a hand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from firstcontact.device import Arrival, Descriptor, Health, RecorderStatus
from firstcontact.streaming._events import Event
from firstcontact.streaming._hand_requests import Ask


@dataclass(frozen=True, slots=True, eq=False)
class Update:
    """What came since the last one, and how everything is doing.

    Parameters
    ----------
    arrivals
        Samples, in order.
    events
        What the pipeline found in them.
    health
        Of the source.
    recording
        Of the recorder.
    ledger
        The time ledger's figures so far, by name; times in s.
    failed
        What each sink that failed died of, by its name: for the others to tell.
    """

    arrivals: tuple[Arrival, ...] = ()
    events: tuple[Event, ...] = ()
    health: Health = field(default_factory=Health)
    recording: RecorderStatus = field(default_factory=RecorderStatus)
    ledger: Mapping[str, float] = field(default_factory=dict)
    failed: Mapping[str, str] = field(default_factory=dict)


class Sink(Protocol):
    """Takes updates in a thread of its own.

    It may be slow or raise: its queue is bounded, what does not fit is dropped
    and counted, and nothing else notices.
    """

    @property
    def name(self) -> str:
        """What drops are reported under."""

    @property
    def every(self) -> float:
        """Longest that samples may be held back for it, s; events and markers never are."""

    def open(self, descriptor: Descriptor) -> None:
        """Begin: called once, before the first update."""

    def take(self, update: Update) -> None:
        """Use an update."""

    def close(self) -> None:
        """End; called once, on every way out."""


class Controls(Protocol):
    """What a viewer may ask for; safe to call from any thread."""

    def start_recording(self) -> Path:
        """Begin a recording; InputError when one is running or cannot be made."""

    def stop_recording(self) -> None:
        """Close the recording; nothing happens when none is running."""

    def mark(self, text: str) -> None:
        """Pin a word to the next sample."""

    def hand_asks(self) -> tuple[Ask, ...]:
        """What the hand can be asked; nothing where none is driven."""

    def ask_hand(self, ask: Ask, by: str) -> None:
        """Ask the hand for something; InputError where it cannot be asked for that, or not now."""

    def hand_gone(self, by: str) -> None:
        """Somebody can ask no more: what they had the hand close is opened."""

    def new_object(self) -> None:
        """The next pinches are of another object: they are combined, and nothing across."""

    @property
    def shapes(self) -> bool:
        """Whether it is of use to tell the shape of what is pinched."""

    def tell_shape(self, text: str) -> str:
        """What is pinched next has this shape; what was understood, or InputError."""
