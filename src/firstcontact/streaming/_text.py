"""Pinches as lines of text."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TextIO

from firstcontact.core import finger_name
from firstcontact.device import Descriptor, Health, LinkNews, lost_object
from firstcontact.streaming._events import (
    Estimated,
    HandAsked,
    HandCheck,
    HandPinch,
    PinchDone,
    Running,
    SameObject,
)
from firstcontact.streaming._lines import write_now
from firstcontact.streaming._sink import Update
from firstcontact.streaming._spoken import Objects


class TextSink:
    """One line a pinch, and one whenever the link loses something or comes back, or a sink fails.

    Parameters
    ----------
    stream
        Where to.
    shore_a
        Of an object of the twin by its name, None where it is not known: told with its pinches.
    """

    name = "text"
    every = 0.1

    def __init__(
        self, stream: TextIO, shore_a: Callable[[str], float | None] = lambda name: None
    ) -> None:
        self._stream = stream
        self._rate = 0.0
        self._alone = False  # one sensor: no second contact can come
        self._link = LinkNews(Health(connected=True))
        self._health = Health(connected=True)
        self._objects = Objects(shore_a)
        self._failed: Mapping[str, str] = {}

    def open(self, descriptor: Descriptor) -> None:
        """Say what is connected."""
        self._rate = descriptor.layout.rate
        self._alone = len(descriptor.layout.vibration_fingers) < 2
        what = ", ".join(s for s in (descriptor.firmware, descriptor.sensor) if s)
        self._say(f"{descriptor.source}: {what or 'unnamed'}, {self._rate:g} Hz")

    def take(self, update: Update) -> None:
        """Say what an update brings."""
        self._health = update.health
        for line in self._link.lines(update.health):
            self._say(line)
        for name, why in update.failed.items() - self._failed.items():
            self._say(f"{name}: failed ({why})")
        self._failed = update.failed
        for how in (lost_object(m.text) for a in update.arrivals for m in a.markers):
            if how:
                self._say(f"the hand has {how} it")
        late: list[tuple[int, str]] = []
        for arrival in update.arrivals:
            self._objects.words(arrival.markers)
            late += self._objects.labels(arrival.pinches)
        for event in update.events:
            if isinstance(event, PinchDone):
                what = self._objects.of(event)
                line = pinch_line(event, self._alone)
                self._say(f"{line}, {what}" if what else line)
            elif isinstance(event, HandAsked):
                self._say(f"hand told to {event.ask}, by {event.by}")
            elif isinstance(event, HandPinch):
                self._say(hand_line(event, self._rate))
            elif isinstance(event, SameObject) and event.pinches > 1:
                self._say(same_line(event))
        for number, what in late:
            self._say(f"  pinch {number} was {what}")

    def close(self) -> None:
        """Say what the link has lost since that was last said."""
        for line in self._link.lines(self._health, last=True):
            self._say(line)

    def _say(self, line: str) -> None:
        write_now(self._stream, f"{line}\n")


def pinch_line(done: PinchDone, alone: bool = False) -> str:
    """A pinch on one line; ``alone`` where no second contact can come.

    First the estimate that was available before the second contact, then all others.
    """
    judged = not alone and done.case is not None
    shown = done.available if judged else done.final
    parts = [f"pinch {done.number}: {finger_name(done.contacts[0].finger)} first"]
    if judged and shown is None and done.final is not None:
        parts.append("no estimate in time")
    for e in dict.fromkeys((shown, done.final, *done.estimates)):
        if e is not None:
            of = isinstance(e, Estimated) and done.answers
            model = f"model of {1e3 * e.duration:.0f} ms: " if of else ""
            case = f", {done.case_of(e)}" if judged else ""
            parts.append(f"{model}{estimate_words(e, done.rate if done.real_time else None)}{case}")
    if done.refused:
        parts.append(f"no estimate: {done.refused}")
    if done.offset is not None:
        parts.append(f"second after {1e3 * done.offset:.1f} ms")
    return ", ".join(parts)


def estimate_words(e: Running | Estimated, rate: float | None) -> str:
    """An estimate, and how long after the contact it was available.

    ``rate`` is in Hz, and None where that time means nothing.
    """
    bounds = f" ({e.low:.0f} to {e.high:.0f})" if e.level else ""
    signal = f" from {1e3 * e.duration:.0f} ms" if isinstance(e, Running) else ""
    odd = ", out of range" if isinstance(e, Running) and e.strange else ""
    at = "" if rate is None else f" at {1e3 * e.after(rate):.1f} ms"
    return f"{e.value:.1f} Shore A{bounds}{signal}{at}{odd}"


def hand_line(event: HandPinch, rate: float) -> str:
    """What a device that answers by itself told of a pinch; ``rate`` in Hz."""
    parts = []
    stands = event.standing
    if event.first is None:
        parts.append("no contact")
    elif stands is None:
        parts.append(f"{finger_name(event.first.finger)} first, no estimate")
    else:
        odd = ", out of range" if stands.out_of_range else ""
        parts.append(
            f"{stands.value:.1f} Shore A ({stands.low:.0f} to {stands.high:.0f}) from "
            f"{1e3 * stands.samples / rate:.0f} ms at {1e3 * stands.after(rate):.1f} ms{odd}"
        )
    parts.append("not checked" if event.check is None else check_words(event.check))
    return f"  on the hand (model {event.model}): {', '.join(parts)}"


def check_words(check: HandCheck) -> str:
    """What the host says of the hand's answers."""
    if check.same:
        return f"the same here ({check.compared} answers)"
    if check.lost:
        return "not heard here: samples were lost"
    parts = [] if check.contacts else ["other contacts"]
    parts += [f"{check.missing} answers only on one side"] if check.missing else []
    parts += [] if check.flags else ["another verdict on its range"]
    parts += [f"up to {check.largest:.2f} Shore A apart"] if check.compared else []
    return "differs here: " + ", ".join(parts)


def same_line(event: SameObject) -> str:
    """What the pinches of one object say together."""
    return (
        f"the same object, {event.pinches} pinches: {event.value:.1f} Shore A "
        f"({event.low:.0f} to {event.high:.0f})"
    )
