"""Output of a line of text for each pinch, for people."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import suppress
from typing import TextIO

from firstcontact.core import Estimate, InputError, finger_name
from firstcontact.core.quantity import SHORE_A
from firstcontact.device import SOURCES, Descriptor, Health, Source
from firstcontact.device.source import LinkNews
from firstcontact.device.twin_words import parse_held_object, parse_lost_object
from firstcontact.streaming._objects import ObjectNames
from firstcontact.streaming._sinks import Update
from firstcontact.streaming.events import (
    HandCheck,
    HandCommand,
    HandPinch,
    ObjectEstimate,
    PinchDone,
)
from firstcontact.streaming.outputs import OutputKind


class TextSink:
    """Sink that writes a line of text for each pinch, data loss, reconnection and failed output.

    ``shore_a`` returns the Shore A of a simulated object by its name, or None.
    """

    name = "text"
    every = 0.1

    def __init__(
        self, stream: TextIO, shore_a: Callable[[str], float | None] = lambda name: None
    ) -> None:
        self._stream = stream
        self._alone = False  # a single sensor hears no second contact
        self._link = LinkNews(Health(connected=True))
        self._health = Health(connected=True)
        self._shore_a = shore_a
        self._names = ObjectNames()

    def open(self, descriptor: Descriptor) -> None:
        rate = descriptor.layout.rate
        self._alone = len(descriptor.layout.vibration_fingers) < 2
        names = ", ".join(s for s in (descriptor.firmware, descriptor.sensor) if s)
        self._write(f"{descriptor.source}: {names or 'unnamed'}, {rate:g} Hz")

    def take(self, update: Update) -> None:
        self._health = update.health
        for line in self._link.lines(update.health):
            self._write(line)
        for name, reason in update.failed.items():
            self._write(f"{name}: failed ({reason})")
        for loss in (parse_lost_object(m.text) for a in update.arrivals for m in a.markers):
            if loss:
                self._write(f"the hand has {loss} the object")
        for arrival in update.arrivals:
            self._names.add_markers(arrival.markers)
            self._names.add_labels(arrival.pinches)
        for event in update.events:
            if isinstance(event, PinchDone):
                self._names.add_pinch(event)
                name = self._name(event)
                line = pinch_line(event, self._alone)
                self._write(f"{line}, {name}" if name else line)
            elif isinstance(event, HandCommand):
                self._write(f"hand: {event.ask}, by {event.by}")
            elif isinstance(event, HandPinch):
                self._write(hand_line(event))
            elif isinstance(event, ObjectEstimate) and event.pinches > 1:
                words = SHORE_A.words(event.value, event.low, event.high)
                self._write(f"the same object, {event.pinches} pinches: {words}")

    def close(self) -> None:
        """Write a line about lost samples that were not reported yet."""
        for line in self._link.lines(self._health, last=True):
            self._write(line)

    def _name(self, pinch: PinchDone) -> str:
        for text in reversed(self._names.markers(pinch)):
            object_ = parse_held_object(text)
            return f'marked "{text}"' if object_ is None else text + _shore(self._shore_a(object_))
        label = self._names.label(pinch)
        if label is None or not label.object:
            return ""
        return f"labelled {', '.join(filter(None, [label.object, label.value_words]))}"

    def _write(self, line: str) -> None:
        self._stream.write(f"{line}\n")
        self._stream.flush()


def _shore_a(source: Source) -> Callable[[str], float | None]:
    """Return a function that gives the Shore A of a simulated object by its name.

    The function returns None for unknown names and for sources other than the twin.
    """
    known = SOURCES["twin"].shore_a if source.descriptor.source == "twin" else None

    def shore_a(name: str) -> float | None:
        with suppress(InputError):  # an object of another version
            return None if known is None else known(name)
        return None

    shore_a("")  # load the table of objects now, not between samples
    return shore_a


TEXT = OutputKind(
    "text",
    lambda session, options: TextSink(sys.stdout, _shore_a(session.source)),
    to_stdout=True,
)


def _shore(shore_a: float | None) -> str:
    return "" if shore_a is None else f", {SHORE_A.label_words(shore_a)}"


def pinch_line(pinch: PinchDone, alone: bool = False) -> str:
    is_judged = not alone and pinch.verdict is not None
    judged = pinch.in_force if is_judged else pinch.final
    parts = [f"pinch {pinch.number}: {finger_name(pinch.contacts[0].finger)} first"]
    if is_judged and judged is None and pinch.final is not None:
        parts.append("no estimate in time")
    later = None if pinch.final is judged else pinch.final
    for estimate in (judged, later):
        if estimate is None:
            continue
        words = estimate_words(estimate, timed=pinch.real_time)
        late = "" if not is_judged else ", in time" if estimate.in_time else ", too late"
        parts.append(f"{words}{late}")
    if pinch.reason:
        parts.append(f"no estimate: {pinch.reason}")
    if is_judged and pinch.hand_used is not None:
        parts.append("used by the hand" if pinch.hand_used else "not used by the hand")
    if pinch.offset is not None:
        parts.append(f"second after {1e3 * pinch.offset:.1f} ms")
    if pinch.delay_cause:
        parts.append(pinch.delay_cause)
    if pinch.closing_speed is not None:
        parts.append(f"closed at {1e3 * pinch.closing_speed.speed:.0f} mm/s")
    return ", ".join(parts)


def estimate_words(estimate: Estimate, *, timed: bool) -> str:
    """Return an estimate in words. With ``timed``, also state when it was available."""
    e = estimate
    at = f" at {1e3 * e.available:.1f} ms" if timed else ""
    flag = ", out of range" if e.out_of_range else ""
    return f"{e.words} from {1e3 * e.elapsed:.0f} ms{at}{flag}"


def hand_line(event: HandPinch) -> str:
    if not event.contacts:
        words = "no contact"
    elif event.final is None:
        words = f"{finger_name(event.contacts[0].finger)} first, no estimate"
    else:
        words = estimate_words(event.final, timed=True)
    return f"  on the hand (model {event.model}): {words}, {_check_words(event.check)}"


def _check_words(check: HandCheck | None) -> str:
    if check is None:
        return "not checked"
    if check.same:
        return f"the same on this computer ({check.compared} estimates)"
    if check.lost:
        return "not compared: this computer lost samples"
    return "differs on this computer"
