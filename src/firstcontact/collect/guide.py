"""Guide of a recording, which names the next object and judges each closing of the hand."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from firstcontact.collect._closing_check import ClosingCheck
from firstcontact.contact import ThresholdDetector
from firstcontact.contact.closing import ClosingBegan, Closings, ClosingSamples
from firstcontact.core import (
    ArgumentError,
    Block,
    Calibration,
    ChannelKind,
    FileError,
    InputError,
    Label,
    Layout,
    Role,
)
from firstcontact.core.quantity import MODULUS, SHORE_A, STIFFNESS
from firstcontact.core.records import LONGEST_NAME
from firstcontact.core.text import check_text, parse_float, parse_int
from firstcontact.device import Arrival
from firstcontact.device.twin_words import parse_held_object
from firstcontact.recording import PinchMark
from firstcontact.recording.table import read_rows
from firstcontact.recording.untrusted import quote

_log = logging.getLogger("firstcontact.collect")

#: Largest number of pinches of an object in a session.
MOST_PINCHES = 1_000_000
#: Columns that state a quantity.
_MEASURED = {"shore": SHORE_A, MODULUS.name: MODULUS, STIFFNESS.name: STIFFNESS}
#: Columns of a plan; the first two must be there.
COLUMNS = ("object", "pinches", "shore", "specimen", "role", MODULUS.name, STIFFNESS.name)
#: Threshold of the detector that checks the strips: a click of the motor stays below it, and a
#: touch is far above it.
SIGMAS = 10.0
#: Length of the pieces in which blocks are processed, s: a closing cannot begin and end within one.
PIECE = 0.015
#: Length of the pieces of stream in which noise is measured, s.
QUIET = 0.1


@dataclass(frozen=True, slots=True)
class Item:
    """One object of a recording's plan, with the number of valid pinches to record."""

    object: str
    pinches: int
    shore: float | None = None  # Shore A
    specimen: str = ""  # if its name differs from that of the object
    role: Role = Role.TRAIN
    modulus_mpa: float | None = None
    stiffness_n_per_mm: float | None = None

    def __post_init__(self) -> None:
        if not self.object or max(len(self.object), len(self.specimen)) > LONGEST_NAME:
            raise ArgumentError(
                f"the names of object and specimen must have 1 to {LONGEST_NAME} characters: give "
                "other names"
            )
        for name in (self.object, self.specimen):
            check_text(name)
        if not 1 <= self.pinches <= MOST_PINCHES:
            raise ArgumentError(
                f"the number of pinches of {self.object} is {self.pinches}: give a number from 1 "
                f"to {MOST_PINCHES}"
            )
        for name, quantity in _MEASURED.items():
            value = getattr(self, name)
            if value is not None and not quantity.least <= value <= quantity.most:
                raise ArgumentError(
                    f"{name} of {self.object} is {value:g}: give a value in {quantity.unit} from "
                    f"{quantity.least:g} to {quantity.most:g}"
                )
        if sum(getattr(self, name) is not None for name in _MEASURED) > 1:
            names = ", ".join(_MEASURED)
            raise ArgumentError(f"{self.object} has more than one of {names}: keep one of them")

    def label(self, session: str) -> Label:
        """Return the label of this object's pinches in the session called ``session``."""
        specimen = self.specimen or self.object
        return Label(
            self.object,
            self.shore,
            None,
            specimen,
            session,
            self.role,
            modulus_mpa=self.modulus_mpa,
            stiffness_n_per_mm=self.stiffness_n_per_mm,
        )


def read_plan(path: Path) -> tuple[Item, ...]:
    """Read the plan of a recording, a CSV with the columns ``COLUMNS`` and one row per object.

    Raises FileError, which names the line, for a row that cannot be used.
    """
    rows = read_rows(path, COLUMNS[:2])
    for name in rows[0][1] if rows else ():
        if name not in COLUMNS:
            raise FileError(
                f"{path}: the column {name!r} is unknown: use only {', '.join(COLUMNS)}"
            )
    items = tuple(_item(path, line, row) for line, row in rows)
    if not items:
        raise FileError(f"{path} has no objects: add a line for each object")
    labels = [item.label("") for item in items]
    for k, label in enumerate(labels):
        if label in labels[:k]:
            raise FileError(
                f"{path}, line {rows[k][0]}: {label.specimen} is listed twice: keep one line"
            )
    return items


def _item(path: Path, line: int, cells: Mapping[str, str]) -> Item:
    readers: dict[str, Callable[[str], Any]]
    readers = {"pinches": parse_int, "role": Role, **dict.fromkeys(_MEASURED, parse_float)}
    values: dict[str, Any] = {
        name: text for name, text in cells.items() if text or name in COLUMNS[:2]
    }
    try:
        for name in (name for name in readers if name in values):
            try:
                values[name] = readers[name](values[name])
            except ValueError as error:
                kind = "train or test" if name == "role" else "a number"
                raise ArgumentError(f"{name} is {quote(values[name])}: give {kind}") from error
        return Item(**values)
    except InputError as error:
        raise FileError(f"{path}, line {line}: {error}") from error


@dataclass(frozen=True, slots=True)
class Judged:
    """Result of a closing that touched an object. Without ``faults`` it is a valid pinch."""

    label: Label
    faults: tuple[str, ...]
    mark: PinchMark | None
    #: Number of valid pinches of the object so far, and of wanted ones.
    k: int
    wanted: int
    #: Time from the first to the second contact, by the strips, s.
    offset: float | None
    #: Time from the first strip's contact to that of the same finger's piezo, s.
    disagreement: float | None
    #: Noise of the louder finger in the quietest 0.1 s since the last closing, in noise floors.
    noise: float


class Guide:
    """Guide that names the object to pinch, and decides if a closing is a valid pinch.

    ``items`` is the plan of objects. ``recorded`` counts the valid pinches that earlier files of
    the session already hold, by label.
    """

    def __init__(
        self,
        layout: Layout,
        items: Sequence[Item],
        session: str,
        calibration: Calibration,
        recorded: Counter[Label] | None = None,
    ) -> None:
        self.layout = layout
        #: True during a pause. Closings that begin in it do not count.
        self.paused = False
        #: Number of closings that touched an object but did not count.
        self.left_out = 0
        self._wanted = {item.label(session): item.pinches for item in items}
        self._done = Counter(recorded or {})
        self._closings = Closings(layout, ThresholdDetector(SIGMAS), calibration)
        self._check: ClosingCheck | None = None
        self._number = 0
        self._next: tuple[int, int] | None = None
        self._piece = max(1, round(PIECE * layout.rate))
        self._announced = ""
        floors = [calibration.noise(f) or np.inf for f in layout.vibration_fingers]
        self._noise = _Noise(layout, np.array(floors))

    @property
    def current(self) -> Label | None:
        """Label of the object to pinch now; None when all pinches are recorded."""
        left = (label for label, wanted in self._wanted.items() if self._done[label] < wanted)
        return next(left, None)

    @property
    def objects(self) -> int:
        """Number of different objects in the plan."""
        return len(self._wanted)

    @property
    def noise(self) -> float:
        """Noise in the quietest 0.1 s since the last closing, divided by the calibrated noise."""
        return self._noise.ratio

    def progress(self, label: Label) -> tuple[int, int]:
        """Return how many valid pinches of an object are recorded, and how many are planned."""
        return self._done[label], self._wanted[label]

    def update(self, arrival: Arrival) -> list[Judged]:
        """Process the next samples. Return the results of the closings that have ended."""
        for marker in arrival.markers:
            self._announced = parse_held_object(marker.text) or self._announced
        block = arrival.block
        judged: list[Judged] = []
        for start in range(0, len(block.data), self._piece):
            data = block.data[start : start + self._piece]
            judged += self._take(Block(data, block.first_sample + start, block.epoch))
        return judged

    def finish(self) -> list[Judged]:
        """Return the result of a closing that had not ended at the last sample; [] without one."""
        check = self._check
        return self._judge() if check is not None and check.anchor is not None else []

    def _take(self, block: Block) -> list[Judged]:
        judged: list[Judged] = []
        if self._check is not None and (block.first_sample, block.epoch) != self._next:
            self._check.lost = True
            judged += self._judge()
        self._next = (block.end, block.epoch)
        self._noise.update(block)
        for event in self._closings.update(block):
            if isinstance(event, ClosingBegan):
                judged += self._judge()
                if not self.paused:
                    self._check = ClosingCheck(self.layout, event.sample, event.epoch)
            elif isinstance(event, ClosingSamples) and self._check is not None:
                # A contact after the end of the pinch belongs to no pinch.
                end = self._check.end
                for contact in event.contacts:
                    if end is None or contact.sample < end:
                        self._check.contacts.setdefault(contact.finger, contact)
        if self._check is not None:
            self._check.follow(block)
            if self._check.end is not None and self._check.seen >= self._check.end:
                judged += self._judge()
        return judged

    def _judge(self) -> list[Judged]:
        check, self._check = self._check, None
        label = self.current
        if check is None or check.anchor is None or label is None or self.paused:
            return []
        faults = check.faults()
        if self._announced and self._announced != label.object:
            faults = [f"the twin still held {self._announced}"]
        mark = None
        if faults:
            self.left_out += 1
            _log.info("a closing on %s does not count: %s", label.object, "; ".join(faults))
        else:
            end = min(check.end or check.seen, check.seen)
            detected = tuple(c for c in check.detected if c.sample < end)
            by = ThresholdDetector.name if detected else ""
            place = self._number, check.began, end, check.epoch
            mark = PinchMark(*place, label, check.truth, found=detected, found_by=by)
            self._number += 1
            self._done[label] += 1
        truth = check.truth
        offset = (truth[1].sample - truth[0].sample) / self.layout.rate if truth[1:] else None
        noise = self._noise.ratio
        self._noise.restart()
        k, wanted = self.progress(label)
        return [Judged(label, tuple(faults), mark, k, wanted, offset, check.disagreement(), noise)]


class _Noise:
    """Meter of the noise in the quietest 0.1 s, as a multiple of the calibrated noise.

    ``floors`` are the calibrated noises of the vibration channels. ``ratio`` is the result: the
    multiple for the channel in which it is largest.
    """

    def __init__(self, layout: Layout, floors: np.ndarray) -> None:
        self._layout, self._floors = layout, floors
        self._columns = layout.columns(ChannelKind.VIBRATION)
        self._length = round(QUIET * layout.rate)
        self._waiting = np.zeros((0, len(self._columns)))
        self.ratio = 0.0

    def restart(self) -> None:
        self._waiting, self.ratio = self._waiting[:0], 0.0

    def update(self, block: Block) -> None:
        values = self._layout.physical(block.data, self._columns)
        self._waiting = np.concatenate([self._waiting, values])
        if len(self._waiting) >= self._length:
            ratio = float((self._waiting.std(axis=0) / self._floors).max())
            self.ratio = min(self.ratio, ratio) if self.ratio else ratio
            self._waiting = self._waiting[:0]
