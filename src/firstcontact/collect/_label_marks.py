"""Contacts that a person labels on the labelling page, and the journal of the person's actions."""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from operator import attrgetter
from pathlib import Path
from typing import IO, Annotated, Any, Literal

from msgspec import Meta

from firstcontact.core import ArgumentError, FileError, InputError, Label
from firstcontact.core.files import read_regular
from firstcontact.core.quantity import MODULUS, PHYSICAL, SHORE_A, STIFFNESS
from firstcontact.core.records import Name, read_record
from firstcontact.recording.messages import LAST_SAMPLE

#: Largest number of onsets, and of actions, of a labelling.
MOST = 100_000
#: Largest journal, bytes.
LONGEST = 1 << 27


class Status(StrEnum):
    """Decision of a person about a detected contact; ``FOUND`` means that there is none yet."""

    FOUND = "found"
    ACCEPTED = "accepted"
    REJECTED = "rejected"


@dataclass(frozen=True, slots=True)
class Mark:
    """Contact (onset) in a recording, with a person's decision about it and a label.

    ``recording``, ``stretch`` and ``column`` are the indices of the recording, of the block in it,
    and of the vibration channel. ``sample`` is counted from the start of the block. ``found`` is
    the sample at which the contact was detected, None if the person added it.
    """

    number: int
    recording: int
    stretch: int
    column: int
    sample: int
    found: int | None
    status: Status = Status.FOUND
    object: str = ""
    shore_a: float | None = None
    modulus_mpa: float | None = None
    stiffness_n_per_mm: float | None = None


def measured(label: Label | Mark | Action) -> dict[str, Any]:
    """Return a label's Shore A, modulus and stiffness by field name; None if unknown."""
    return {quantity.name: getattr(label, quantity.name) for quantity in PHYSICAL}


Whole = Annotated[int, Meta(ge=0, le=LAST_SAMPLE)]


@dataclass(frozen=True, slots=True)
class Action:
    """Action of a person on the labelling page, such as a decision about contact ``number``."""

    do: Literal["accept", "reject", "move", "add", "label", "undo"]
    number: Whole = 0
    sample: Whole = 0
    object: Name = ""
    shore_a: Annotated[float, Meta(ge=SHORE_A.least, le=SHORE_A.most)] | None = None
    modulus_mpa: Annotated[float, Meta(ge=MODULUS.least, le=MODULUS.most)] | None = None
    stiffness_n_per_mm: Annotated[float, Meta(ge=STIFFNESS.least, le=STIFFNESS.most)] | None = None


class Marks:
    """Contacts of some recordings, as they are after a person's actions so far.

    ``onsets`` are the detected contacts. ``lengths`` are the numbers of samples of each block of
    each recording.
    """

    def __init__(self, onsets: Sequence[Mark], lengths: Sequence[Sequence[int]]) -> None:
        self._onsets = tuple(onsets)
        self._lengths = lengths
        self.done: list[Action] = []
        self._marks = {mark.number: mark for mark in onsets}
        self._runs: dict[int, Action] = {}

    def __len__(self) -> int:
        return len(self._marks)

    def ordered(self) -> list[Mark]:
        """Return all contacts by recording and time.

        A contact that the person did not label gets the label of the contact before it.
        """
        ordered = []
        run: Action | None = None
        recording = 0
        place = attrgetter("recording", "stretch", "sample", "number")
        for mark in sorted(self._marks.values(), key=place):
            if mark.recording != recording:
                run, recording = None, mark.recording
            run = self._runs.get(mark.number, run)
            if run is not None:
                mark = replace(mark, object=run.object, **measured(run))
            ordered.append(mark)
        return ordered

    def act(self, action: Action) -> int:
        """Apply an action, or undo the last one. Return the number of the changed contact.

        Raises ArgumentError if the action is not possible.
        """
        if action.do == "undo":
            if not self.done:
                raise ArgumentError(
                    "there is no label left to undo: accept or reject an onset first"
                )
            reopened = self.done[-1].number
            self.replay(self.done[:-1])
            return reopened
        number = self._do(action)
        self.done.append(action)
        return number

    def replay(self, actions: Iterable[Action]) -> None:
        """Start again from the detected contacts, and apply ``actions``."""
        self._marks = {mark.number: mark for mark in self._onsets}
        self._runs, self.done = {}, []
        for action in actions:
            self.act(action)

    def _do(self, action: Action) -> int:
        mark = self._marks.get(action.number)
        if mark is None:
            raise ArgumentError(f"there is no onset {action.number}: load the page again")
        number = mark.number
        match action.do:
            case "accept":
                mark = replace(mark, status=Status.ACCEPTED)
            case "reject":
                mark = replace(mark, status=Status.REJECTED)
            case "move":
                sample = self._inside(mark, action.sample)
                mark = replace(mark, sample=sample, status=Status.ACCEPTED)
            case "add":
                if len(self._marks) >= MOST:
                    raise ArgumentError(
                        f"the page already has {MOST} onsets, the largest number: label "
                        "fewer recordings in one command"
                    )
                sample, number = self._inside(mark, action.sample), max(self._marks) + 1
                mark = replace(
                    mark, number=number, sample=sample, found=None, status=Status.ACCEPTED
                )
            case "label":
                self._runs[number] = action
        self._marks[number] = mark
        return number

    def _inside(self, mark: Mark, sample: int) -> int:
        length = self._lengths[mark.recording][mark.stretch]
        if not 0 <= sample < length:
            raise ArgumentError(
                f"sample {sample} is outside the unbroken signal (0 to {length - 1}): "
                "place the onset within it"
            )
        return sample


@dataclass(frozen=True, slots=True)
class Opened:
    """First line of a journal: names of the recordings, and number of contacts detected in them."""

    labelling: tuple[str, ...]
    found: int


class Journal:
    """File that stores each labelling action before the page gets a reply.

    An existing file is read and continued: ``actions`` are those in it. Raises FileError if the
    file belongs to other recordings than ``opened`` or is in use, or if it would be new and
    ``is_new_allowed`` is False.
    """

    def __init__(self, path: Path, opened: Opened, is_new_allowed: bool = True) -> None:
        self.path = path
        self.actions: list[Action] = []
        self.lost_bytes = 0
        #: Position of the next line. An incomplete line stays there until the next one is written.
        self._end = 0
        is_there = path.exists()
        if is_there:
            self._read(opened)
        if not self.actions and not is_new_allowed:
            raise FileError(
                f"{path} holds no labels, so there is nothing to write: label on the page first"
            )
        try:
            # Without a buffer, which would keep bytes that could not be written.
            self._stream: IO[bytes] = path.open("r+b" if is_there else "xb", buffering=0)
        except OSError as error:
            raise self._failed(error) from error
        try:
            self._lock()
            if is_there:  # read again: the last command with the lock may have written
                self._end = self._read(opened)
            if not self._end:
                self.add(opened)
        except BaseException:
            self._stream.close()
            raise

    def close(self) -> None:
        """Close the file. A second call does nothing."""
        self._stream.close()

    def add(self, entry: Opened | Action) -> None:
        """Append an entry, and wait until it is on the disk. Raise FileError if that fails."""
        try:
            self._stream.truncate(self._end)
            self._stream.seek(self._end)
            unwritten = memoryview(_encode_line(entry))
            while unwritten:
                unwritten = unwritten[self._stream.write(unwritten) :]
            os.fsync(self._stream.fileno())
            self._end = self._stream.tell()
        except OSError as error:
            raise self._failed(error) from error

    def _lock(self) -> None:
        """Lock the file until it is closed. Raise FileError if another command has locked it."""
        try:
            fcntl.flock(self._stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise FileError(
                f"{self.path} is in use by another `firstcontact label`: end that command, or "
                "choose another folder"
            ) from None
        except OSError:
            return  # a disk without locks

    def _read(self, opened: Opened) -> int:
        """Read all actions in the file. Return the position after the last complete line.

        Raises FileError if the file is damaged or belongs to other recordings.
        """
        try:
            raw = read_regular(self.path, LONGEST)
        except OSError as error:
            raise self._failed(error) from error
        end = raw.rfind(b"\n") + 1
        remedy = "move it away to start again, or choose another folder"
        if not end:
            # A crash can cut off the first line. A power cut can leave zeros instead of labels.
            if not _encode_line(opened).startswith(raw):
                raise FileError(
                    f"{self.path} is damaged (none of its {len(raw)} bytes can be read): {remedy}"
                )
            return 0
        first, *lines = raw[:end].splitlines()
        if read_record(first, Opened, f"{self.path}: line 1", remedy) != opened:
            raise FileError(f"{self.path} was written for other recordings: {remedy}")
        remedy = "remove this line and all behind it to keep the labels before it"
        self.actions = [
            read_record(line, Action, f"{self.path}: line {number}", remedy)
            for number, line in enumerate(lines, 2)
        ]
        self.lost_bytes = len(raw) - end
        return end

    def _failed(self, error: OSError) -> InputError:
        return FileError(
            f"{self.path} cannot be written ({error.strerror}): your earlier labels are in it; "
            "make room on the disk and run the same command again"
        )


def _encode_line(entry: Opened | Action) -> bytes:
    return json.dumps(asdict(entry), ensure_ascii=False).encode() + b"\n"
