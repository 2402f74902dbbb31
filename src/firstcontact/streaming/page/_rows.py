"""Rows of the page's table: the last pinches with the names of their objects."""

from __future__ import annotations

from collections import deque

import msgspec

from firstcontact.device import lost_object
from firstcontact.recording import Marker, PinchMark
from firstcontact.streaming._events import HandPinch, PinchDone
from firstcontact.streaming._objects import ObjectNames
from firstcontact.streaming._text import hand_line

#: Number of rows.
ROWS = 12


class Row(msgspec.Struct, frozen=True):
    """Row of the table."""

    pinch: PinchDone
    name: str = ""
    lost: str | None = None
    hand: str = ""


def brief(pinch: PinchDone) -> PinchDone:
    """Return the pinch with only two estimates: the last one in time, and the final one."""
    estimates = tuple(e for e in (pinch.in_force, pinch.final) if e is not None)
    if len(estimates) == 2 and estimates[0] is estimates[1]:
        estimates = estimates[:1]
    return msgspec.structs.replace(pinch, estimates=estimates)


class PinchRows:
    """Collector of the table's rows for the last pinches, the newest last."""

    def __init__(self) -> None:
        self._rows: deque[Row] = deque(maxlen=ROWS)
        self._names = ObjectNames()
        self._losses: deque[Marker] = deque(maxlen=ROWS)

    def add_marker(self, marker: Marker) -> None:
        """Process a marker. It names the object of a pinch, or reports that an object was lost."""
        if lost_object(marker.text):
            self._losses.append(marker)
        self._names.add_markers([marker])
        self._rename()

    def add_label(self, mark: PinchMark) -> None:
        """Process a label of a replayed recording."""
        self._names.add_labels([mark])
        self._rename()

    def add_pinch(self, pinch: PinchDone) -> None:
        """Add a row."""
        self._names.add_pinch(pinch)
        self._rows.append(Row(brief(pinch)))
        self._rename()

    def hand(self, event: HandPinch) -> None:
        """Add a device's predictions to the row of their pinch."""
        if event.contacts:
            place = event.epoch, event.contacts[0].sample
            words = hand_line(event).strip()
            for i, row in enumerate(self._rows):
                if row.pinch.holds(*place):
                    self._rows[i] = msgspec.structs.replace(row, hand=words)

    def _rename(self) -> None:
        for i, row in enumerate(self._rows):
            label = self._names.label(row.pinch)
            names = [
                row.name,
                *self._names.markers(row.pinch),
                "" if label is None else label.object,
            ]
            name = next(filter(None, reversed(names)), "")
            self._rows[i] = msgspec.structs.replace(row, name=name)

    @property
    def rows(self) -> tuple[Row, ...]:
        """Rows of the table, with the twin's reports of lost objects."""
        rows = []
        following: PinchDone | None = None  # a loss after the start of this pinch belongs to it
        for row in reversed(self._rows):
            losses = (m for m in self._losses if _is_during(m, row.pinch, following))
            lost = next((lost_object(m.text) for m in losses), None)
            rows.append(msgspec.structs.replace(row, lost=lost))
            following = row.pinch
        return tuple(rows[::-1])


def _is_during(marker: Marker, pinch: PinchDone, following: PinchDone | None) -> bool:
    """Return True if a marker lies between the start of a pinch and the start of the next one."""
    place = (marker.epoch, marker.sample)
    if place < (pinch.epoch, pinch.start) or marker.epoch != pinch.epoch:
        return False
    return following is None or place < (following.epoch, following.start)
