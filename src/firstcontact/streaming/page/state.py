"""State of the live page, in parts that are sent when they change. New viewers get all parts."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile
from threading import Lock
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ChannelKind, Estimate, Finger, merge_blocks
from firstcontact.core.display import FAMILIAR
from firstcontact.core.quantity import QUANTITIES, SHORE_A
from firstcontact.device import Arrival, Descriptor
from firstcontact.device.recorder import RecorderStatus
from firstcontact.device.twin_words import parse_lost_object
from firstcontact.recording import Marker, PinchMark
from firstcontact.streaming._objects import ObjectNames
from firstcontact.streaming._sinks import Update
from firstcontact.streaming.events import (
    ContactEvent,
    ContactWithdrawn,
    Event,
    HandCommand,
    HandPinch,
    NoEstimate,
    ObjectEstimate,
    PinchDone,
)
from firstcontact.streaming.page.traces import SECONDS, Closeup, Columns, finger_place
from firstcontact.streaming.text import hand_line

if TYPE_CHECKING:
    from firstcontact.streaming.session import LiveSession

#: Mean time from the first to the second contact, as published, ms.
BUDGET_MS = 16.65
#: Number of rows in the table of pinches.
ROWS = 12
#: Largest number of contact marks, more than two seconds contain.
MARKS = 64
#: Largest number of updates that wait for a viewer.
PENDING = 20
#: Number of faults that are shown, the newest ones.
FAULTS = 4
#: Time over which the shown force is averaged, s.
FORCE_SECONDS = 0.02


class Row(msgspec.Struct, frozen=True):
    """Row of the page's table: a pinch and the name of its object.

    ``lost`` states how the twin lost the object, and ``hand`` what the device itself predicted.
    """

    pinch: PinchDone
    name: str = ""
    lost: str | None = None
    hand: str = ""


class PinchRows:
    """Rows of the page's table for the latest pinches, the newest last."""

    def __init__(self) -> None:
        self._rows: deque[Row] = deque(maxlen=ROWS)
        self._names = ObjectNames()
        self._losses: deque[Marker] = deque(maxlen=ROWS)

    def add_marker(self, marker: Marker) -> None:
        """Process a marker, which may name an object or report that the twin lost it."""
        if parse_lost_object(marker.text):
            self._losses.append(marker)
        self._names.add_markers([marker])
        self._rename()

    def add_label(self, mark: PinchMark) -> None:
        self._names.add_labels([mark])
        self._rename()

    def add_pinch(self, pinch: PinchDone) -> None:
        self._names.add_pinch(pinch)
        self._rows.append(Row(brief(pinch)))
        self._rename()

    def hand(self, event: HandPinch) -> None:
        for i, row in enumerate(self._rows):
            if event.contacts and row.pinch.holds(event.epoch, event.contacts[0].sample):
                self._rows[i] = msgspec.structs.replace(row, hand=hand_line(event).strip())

    def _rename(self) -> None:
        for i, row in enumerate(self._rows):
            label = self._names.label(row.pinch)
            names = [row.name, *self._names.markers(row.pinch)]
            names.append("" if label is None else label.object)
            name = next(filter(None, reversed(names)), "")
            self._rows[i] = msgspec.structs.replace(row, name=name)

    @property
    def rows(self) -> tuple[Row, ...]:
        """Rows of the table, in which ``lost`` is set for objects that the twin lost."""
        rows = []
        end = (np.inf, np.inf)  # a loss after the start of the following pinch belongs to that one
        for row in reversed(self._rows):
            start = row.pinch.epoch, row.pinch.start
            losses = (
                m for m in self._losses
                if m.epoch == row.pinch.epoch and start <= (m.epoch, m.sample) < end
            )  # fmt: skip
            lost = next((parse_lost_object(m.text) for m in losses), None)
            rows.append(msgspec.structs.replace(row, lost=lost))
            end = start
        return tuple(rows[::-1])


def brief(pinch: PinchDone) -> PinchDone:
    """Return a copy of a pinch with two estimates only: the last one in time, and the final one."""
    in_force, final = pinch.in_force, pinch.final
    estimates = tuple(e for e in (None if in_force is final else in_force, final) if e is not None)
    return msgspec.structs.replace(pinch, estimates=estimates)


class Now(msgspec.Struct, frozen=True):
    """Events of the closing in progress, or else of the last one, as the page shows them."""

    contact: ContactEvent | None = None
    second: float | None = None
    estimates: tuple[Estimate, ...] = ()
    missing: NoEstimate | None = None
    pinch: PinchDone | None = None
    object: ObjectEstimate | None = None


@dataclass(slots=True, eq=False)
class _Part:
    """Part of the page's state: its value, the number of its changes, and its JSON text.

    The text is None until a viewer needs it.
    """

    tree: Any
    count: int
    text: str | None = None


class State:
    """Current state of the live page. One thread writes it, another one reads it."""

    def __init__(
        self, descriptor: Descriptor, landmarks: Mapping[str, float], controls: LiveSession | None
    ) -> None:
        layout = descriptor.layout
        self._layout = layout
        self._lock = Lock()
        self._columns = Columns(layout)
        self._closeup = Closeup(layout)
        self._rows = PinchRows()
        self._marks: deque[dict[str, Any]] = deque(maxlen=MARKS)
        self._now = Now()
        self._pending: list[Update] = []
        self._parts: dict[str, _Part] = {}
        self._faults: list[str] = []
        self._taxels = {f: layout.columns(ChannelKind.FORCE, f) for f in Finger}
        force = layout.columns(ChannelKind.FORCE)
        hello = {
            "source": descriptor.source,
            "sensor": descriptor.sensor,
            "hand": descriptor.hand,
            "firmware": descriptor.firmware,
            "rate": layout.rate,
            "fingers": [finger_place(f) for f in layout.vibration_fingers],
            "unit": layout.vibration[0].unit,
            "force_unit": layout.column_channels[force[0]].unit if force else "",
            "force_fingers": [int(f) for f, columns in self._taxels.items() if columns],
            "column_samples": self._columns.samples,
            "seconds": SECONDS,
            "budget_ms": BUDGET_MS,
            "landmarks": landmarks,
            "familiar": {name: shore_a for name, shore_a, _ in FAMILIAR},
            "quantity": SHORE_A.name,
            "quantities": {
                q.name: {"name": q.name, "unit": q.unit, "is_logarithmic": q.is_logarithmic}
                for q in QUANTITIES.values()
            },
            "controls": False,
            "hand_asks": [],
            "uses_shape": False,
        }
        self.hello = self.look_hello = msgspec.json.encode(hello).decode()
        if controls is not None:
            hello["controls"] = True
            hello["hand_asks"] = controls.hand_asks()
            hello["uses_shape"] = controls.uses_shape
            hello["quantity"] = controls.quantity.name
            self.hello = msgspec.json.encode(hello).decode()

    def take(self, update: Update) -> None:
        with self._lock:
            self._pending.append(update)
            # Without a viewer, consecutive samples are processed together.
            if len(self._pending) >= PENDING:
                self._process_updates()

    def changed(self, seen: dict[str, int]) -> dict[str, str]:
        """Return the JSON of the parts that changed since the last call for a viewer, by name.

        ``seen`` holds the change counts that the viewer has got, and is updated.
        """
        new: dict[str, str] = {}
        with self._lock:
            self._process_updates()
            for name, part in self._parts.items():
                if seen.get(name) != part.count:
                    seen[name] = part.count
                    if part.text is None:  # computed once for all viewers
                        part.text = msgspec.json.encode(part.tree).decode()
                    new[name] = part.text
        return new

    def columns(self, since: int) -> tuple[int, NDArray[np.float32]]:
        """Return the plotted columns from number ``since`` on; see :meth:`Columns.since`."""
        with self._lock:
            self._process_updates()
            return self._columns.since(since)

    def _process_updates(self) -> None:
        """Process the waiting updates in order: first the samples of an update, then its events."""
        pending, self._pending = self._pending, []
        arrivals: list[Arrival] = []
        for update in pending:
            arrivals += update.arrivals
            if update.events or update is pending[-1]:
                self._arrive(arrivals)
                arrivals = []
            for event in update.events:
                self._on_event(event)
            for name, reason in update.failed.items():
                self._faults = [*self._faults, f"{name} has failed: {reason}"][-FAULTS:]
                self._put("faults", self._faults)
        if pending:
            last = pending[-1]
            self._put("health", last.health)
            self._put("recording", _recording(last.recording))
            self._put("ledger", last.ledger)

    def _put(self, name: str, tree: Any) -> None:
        part = self._parts.get(name)
        if part is None or tree != part.tree:
            self._parts[name] = _Part(tree, 1 if part is None else part.count + 1)

    def _arrive(self, arrivals: Sequence[Arrival]) -> None:
        markers = [marker for arrival in arrivals for marker in arrival.markers]
        marks = [mark for arrival in arrivals for mark in arrival.pinches]
        for marker in markers:
            self._rows.add_marker(marker)
        for mark in marks:
            self._rows.add_label(mark)
        if markers or marks:
            self._put("pinches", self._rows.rows)
        blocks = [block for block in merge_blocks(a.block for a in arrivals) if len(block.data)]
        is_closeup_new = False
        for block in blocks:
            self._columns.add(block)
            is_closeup_new |= self._closeup.add(block)
        if is_closeup_new:
            self._put("closeup", self._closeup.tree())
        if blocks:
            recent = blocks[-1].data[-max(1, round(FORCE_SECONDS * self._layout.rate)) :]
            self._put(
                "force", {int(f): self._mean_forces(recent, c) for f, c in self._taxels.items()}
            )

    def _mean_forces(self, data: NDArray[Any], columns: tuple[int, ...]) -> list[float]:
        """Return the mean of each force cell of a finger, row by row of the 3×2 array.

        ``columns`` are the finger's columns in ``data``. The unit is that of the channel. Return []
        if a value is not finite.
        """
        ordered = sorted(columns, key=lambda c: self._layout.column_channels[c].taxel or 0)
        mean = self._layout.physical(data, tuple(ordered)).mean(axis=0)
        return [round(float(v), 3) for v in mean] if np.isfinite(mean).all() else []

    def _on_event(self, event: Event) -> None:
        match event:
            case ContactEvent():
                self._on_contact(event)
            case ContactWithdrawn():
                self._on_withdrawn(event)
            case Estimate():
                self._show(missing=None, estimates=_with(self._now.estimates, event))
            case NoEstimate():
                self._show(missing=event, estimates=())
            case PinchDone():
                self._show(pinch=brief(event))
                self._rows.add_pinch(event)
                self._put("pinches", self._rows.rows)
            case ObjectEstimate():
                self._show(object=event)
            case HandPinch():
                self._rows.hand(event)
                self._put("on_hand", event)
                self._put("pinches", self._rows.rows)
            case HandCommand():
                self._put("hand", event)
            case _:
                pass

    def _show(self, **fields: Any) -> None:
        self._now = msgspec.structs.replace(self._now, **fields)
        self._put("now", self._now)

    def _on_contact(self, event: ContactEvent) -> None:
        contact = event.contact
        place = self._columns.place(contact.sample, event.epoch)
        if place is not None:
            finger = finger_place(contact.finger)
            self._marks.append({"at": round(place, 2), "finger": finger, "first": event.first})
            self._put("marks", list(self._marks))
        if event.first:
            self._now = Now()
            self._show(contact=event)
            if "on_hand" in self._parts:
                self._put("on_hand", None)  # these predictions belong to the previous pinch
            self._closeup.begin(contact, event.epoch)
        else:
            self._closeup.mark(contact)
            first = self._now.contact
            if first is not None and first.epoch == event.epoch:
                self._show(second=(contact.sample - first.contact.sample) / self._layout.rate)
        self._put("closeup", self._closeup.tree())

    def _on_withdrawn(self, event: ContactWithdrawn) -> None:
        place = self._columns.place(event.contact.sample, event.epoch)
        if place is not None:
            at = round(place, 2)
            # The second finger's mark comes after the first one's, even if its sample is earlier.
            marks = takewhile(lambda mark: mark["at"] < at, self._marks)
            self._marks = deque(marks, maxlen=MARKS)
            self._put("marks", list(self._marks))
        self._now = Now()
        self._show()
        self._closeup.clear()
        self._put("closeup", self._closeup.tree())


def _recording(status: RecorderStatus) -> dict[str, Any]:
    return {
        "name": None if status.path is None else status.path.name,
        "samples": status.samples,
        "waiting": status.waiting,
        "failed": status.failed,
    }


def _with(estimates: Sequence[Estimate], estimate: Estimate) -> tuple[Estimate, ...]:
    if estimate.final:
        estimates = [e for e in estimates if e.elapsed < estimate.elapsed]
    return (*estimates, estimate)
