"""What the page shows now: parts that change one by one, for viewers that come and go."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ChannelKind, Finger, merge_blocks
from firstcontact.device import Arrival, Descriptor, RecorderStatus
from firstcontact.streaming._events import (
    Estimated,
    Event,
    HandAsked,
    HandPinch,
    PinchDone,
    Refused,
    Running,
    SameObject,
    Settled,
    Touched,
)
from firstcontact.streaming._sink import Controls, Update
from firstcontact.streaming.page._closeup import Closeup, finger_place
from firstcontact.streaming.page._columns import SECONDS, Columns
from firstcontact.streaming.page._narrowing import Narrowing, estimate_tree
from firstcontact.streaming.page._pinches import Pinches, hand_timing, value

#: Mean time from the first to the second contact, as published, ms.
BUDGET_MS = 16.65
#: Contact marks that are held: more than two seconds have.
MARKS = 64
#: Updates that wait to be looked at, at most.
PENDING = 20
#: Faults that are told: the last so many.
FAULTS = 4
#: Force is shown as the mean of this long, s.
FORCE_SECONDS = 0.02


@dataclass(slots=True, eq=False)
class _Part:
    """A tree, how often it has changed, and its JSON once somebody has asked for it."""

    tree: Any
    count: int
    text: str | None = None


class State:
    """The latest of everything; one thread fills it, another reads it.

    A part is a JSON tree with a count of its changes, so that a viewer is
    told only what it has not seen, however long it was away. What cannot be shown
    is among the faults, and the rest goes on.

    Parameters
    ----------
    descriptor
        Of the source.
    landmarks
        Shore A of known objects, by name.
    controls
        What viewers may ask for; None where they may only look.
    """

    def __init__(
        self, descriptor: Descriptor, landmarks: Mapping[str, float], controls: Controls | None
    ) -> None:
        layout = descriptor.layout
        self._layout = layout
        self._lock = Lock()
        self._columns = Columns(layout)
        self._closeup = Closeup(layout)
        self._pinches = Pinches(layout.rate)
        self._narrowing = Narrowing(layout.rate)
        self._marks: deque[dict[str, Any]] = deque(maxlen=MARKS)
        self._now: dict[str, Any] = {}
        self._first_contact: Touched | None = None
        self._pending: list[Update] = []
        self._parts: dict[str, _Part] = {}
        self._faults: list[str] = []
        self._failed: Mapping[str, str] = {}
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
            "landmarks": {name: float(shore) for name, shore in landmarks.items()},
            "controls": controls is not None,
            "hand_asks": [] if controls is None else [a.value for a in controls.hand_asks()],
            "shapes": controls is not None and controls.shapes,
        }
        #: What does not change while the source is open, JSON.
        self.hello = json.dumps(hello, allow_nan=False)

    def take(self, update: Update) -> None:
        """Put in what came."""
        with self._lock:
            self._pending.append(update)
            # While nobody looks, samples that came one after the other are put in together.
            if len(self._pending) >= PENDING:
                self._settle()

    def _settle(self) -> None:
        """Put in what waits: samples up to each event together, then the event."""
        pending, self._pending = self._pending, []
        arrivals: list[Arrival] = []
        for update in pending:
            arrivals += update.arrivals
            if update.events or update is pending[-1]:
                self._try("samples", self._arrive, arrivals)
                arrivals = []
            for event in update.events:
                self._try(type(event).__name__.lower(), self._happen, event)
            for name, why in update.failed.items() - self._failed.items():
                self._fault(f"{name} has failed: {why}")
            self._failed = update.failed
        if pending:
            last = pending[-1]
            self._put("health", asdict(last.health))
            self._put("recording", _recording(last.recording))
            self._put("ledger", {k: float(v) for k, v in last.ledger.items()})

    def _put(self, name: str, tree: Any) -> None:
        part = self._parts.get(name)
        if part is None or tree != part.tree:
            self._parts[name] = _Part(tree, 1 if part is None else part.count + 1)

    def _try(self, what: str, show: Callable[[Any], None], shown: Any) -> None:
        try:
            show(shown)
        except Exception as error:  # the next may be shown again
            self._fault(f"{what} cannot be shown: {type(error).__name__}: {error}")

    def _fault(self, sentence: str) -> None:
        if sentence not in self._faults:
            self._faults = [*self._faults, sentence][-FAULTS:]
            self._put("faults", self._faults)

    def _arrive(self, arrivals: Sequence[Arrival]) -> None:
        markers = [marker for arrival in arrivals for marker in arrival.markers]
        marks = [mark for arrival in arrivals for mark in arrival.pinches]
        for marker in markers:
            self._pinches.word(marker)
        for mark in marks:
            self._pinches.label(mark)
        if markers or marks:
            self._put("pinches", self._pinches.tree())
        blocks = [block for block in merge_blocks(a.block for a in arrivals) if len(block.data)]
        closer = False
        for block in blocks:
            self._columns.add(block)
            closer |= self._closeup.add(block)
        if closer:
            self._put("closeup", self._closeup.tree())
        if blocks:
            block = blocks[-1]
            recent = block.data[-max(1, round(FORCE_SECONDS * self._layout.rate)) :]
            self._put("force", {int(f): self._force(recent, c) for f, c in self._taxels.items()})

    def _force(self, data: NDArray[Any], columns: tuple[int, ...]) -> list[float]:
        """Mean of each taxel, in the order of their places, row by row."""
        ordered = sorted(columns, key=lambda c: self._layout.column_channels[c].taxel or 0)
        mean = self._layout.physical(data, tuple(ordered)).mean(axis=0)
        return [round(float(v), 3) for v in mean] if np.isfinite(mean).all() else []

    def _happen(self, event: Event) -> None:
        match event:
            case Touched():
                self._touched(event)
            case Running() | Settled() | SameObject():
                self._now = self._narrowing.happened(event, self._now)
                self._put("now", self._now)
            case Estimated() if self._narrowing.begun:
                # The answer at any time is the one that is shown large; this stands beside it.
                self._now = {**self._now, "window": value(event), "window_ms": _ms(event)}
                self._put("now", self._now)
            case Estimated():
                self._now = {
                    **estimate_tree(event, self._layout.rate),
                    "second": self._now.get("second"),
                }
                self._put("now", self._now)
            case Refused() if "estimate" in self._now:
                pass  # one model has no answer, and another has
            case Refused():
                self._now = {"refused": event.reason, "finger": finger_place(event.contact.finger)}
                self._put("now", self._now)
            case PinchDone():
                # Only now: a second contact is told a little after it happens.
                self._now = self._narrowing.done(event, self._now)
                self._put("now", self._now)
                self._pinches.done(event)
                self._put("pinches", self._pinches.tree())
            case HandPinch():
                self._pinches.hand(event)
                self._put("on_hand", hand_timing(event, self._layout.rate))
                self._put("pinches", self._pinches.tree())
            case HandAsked():
                self._put("hand", {"told": event.ask.value, "by": event.by})
            case _:
                pass

    def _touched(self, event: Touched) -> None:
        contact = event.contact
        place = self._columns.place(contact.sample, event.epoch)
        if place is not None:
            self._marks.append(
                {
                    "at": round(place, 2),
                    "finger": finger_place(contact.finger),
                    "first": event.first,
                }
            )
            self._put("marks", list(self._marks))
        if event.first:
            self._first_contact = event
            same = {k: v for k, v in self._now.items() if k == "same"}
            self._now = {"finger": finger_place(contact.finger), **same}
            if "on_hand" in self._parts:
                self._put("on_hand", None)  # it is of the pinch before
            self._narrowing.begin()
            self._closeup.begin(contact, event.epoch)
        else:
            self._closeup.mark(contact)
            if self._first_contact is not None and self._first_contact.epoch == event.epoch:
                after = contact.sample - self._first_contact.contact.sample
                self._now = {**self._now, "second": round(1e3 * after / self._layout.rate, 3)}
        self._put("now", self._now)
        self._put("closeup", self._closeup.tree())

    def changed(self, seen: dict[str, int]) -> dict[str, str]:
        """Parts that changed since ``seen``, which is brought up to date; each as JSON."""
        new: dict[str, str] = {}
        with self._lock:
            self._settle()
            # What cannot be told adds to the faults: these are looked at last.
            for name in (*self._parts.keys() - {"faults"}, "faults"):
                part = self._parts.get(name)
                if part is not None and seen.get(name) != part.count:
                    seen[name] = part.count
                    text = self._told(name, part)
                    if text:
                        new[name] = text
        return new

    def _told(self, name: str, part: _Part) -> str:
        """A part as JSON, made once for all viewers; "" where it cannot be."""
        if part.text is None:
            try:
                part.text = json.dumps(part.tree, allow_nan=False)
            except (ValueError, TypeError) as error:
                part.text = ""
                self._fault(f"{name} cannot be shown: {error}")
        return part.text

    def columns(self, since: int) -> tuple[int, NDArray[np.float32]]:
        """Columns of the traces, as :meth:`Columns.since`."""
        with self._lock:
            self._settle()
            return self._columns.since(since)


def _recording(status: RecorderStatus) -> dict[str, Any]:
    return {
        "name": None if status.path is None else status.path.name,
        "samples": status.samples,
        "waiting": status.waiting,
        "failed": status.failed,
    }


def _ms(estimate: Estimated) -> float:
    return round(1e3 * estimate.duration, 1)
