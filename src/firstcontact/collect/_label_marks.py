"""Onsets that a person labels, and the actions of that person on the page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Annotated, Literal

from msgspec import Meta

from firstcontact.core import InputError, Name
from firstcontact.recording import LAST_SAMPLE

#: Largest number of onsets, and of actions, of a labelling.
MOST = 100_000


class Status(StrEnum):
    """Decision about an onset; ``FOUND`` as long as there is none."""

    FOUND = "found"
    ACCEPTED = "accepted"
    REJECTED = "rejected"


@dataclass(frozen=True, slots=True)
class Mark:
    """Onset in a recording, with the decision about it and its label."""

    number: int
    recording: int
    stretch: int
    column: int
    sample: int
    found: int | None
    status: Status = Status.FOUND
    object: str = ""
    shore_a: float | None = None


Whole = Annotated[int, Meta(ge=0, le=LAST_SAMPLE)]


@dataclass(frozen=True, slots=True)
class Action:
    """Action of the person who labels."""

    do: Literal["accept", "reject", "move", "add", "label", "undo"]
    number: Whole = 0
    sample: Whole = 0
    object: Name = ""
    shore_a: Annotated[float, Meta(ge=0.0, le=100.0)] | None = None


class Marks:
    """Onsets in the order of recordings and time, after all actions."""

    def __init__(self, onsets: Sequence[Mark], lengths: Sequence[Sequence[int]]) -> None:
        self._onsets = tuple(onsets)
        self._lengths = lengths
        self.done: list[Action] = []
        self._marks = {mark.number: mark for mark in onsets}
        self._runs: dict[int, Action] = {}

    def __len__(self) -> int:
        return len(self._marks)

    def ordered(self) -> list[Mark]:
        """Return all onsets in order. An onset without a label gets that of the previous onset."""
        out = []
        run: Action | None = None
        recording = 0
        for mark in sorted(self._marks.values(), key=_place):
            if mark.recording != recording:
                run, recording = None, mark.recording
            run = self._runs.get(mark.number, run)
            labelled = (
                mark if run is None else replace(mark, object=run.object, shore_a=run.shore_a)
            )
            out.append(labelled)
        return out

    def act(self, action: Action) -> int:
        """Apply an action. Return the number of the onset that it changed."""
        if action.do == "undo":
            if not self.done:
                raise InputError("there is no label left to undo")
            reopened = self.done[-1].number
            self.replay(self.done[:-1])
            return reopened
        number = self._do(action)
        self.done.append(action)
        return number

    def replay(self, actions: Iterable[Action]) -> None:
        """Restart from the onset finder's onsets, and apply ``actions``."""
        self._marks = {mark.number: mark for mark in self._onsets}
        self._runs, self.done = {}, []
        for action in actions:
            self.act(action)

    def _do(self, action: Action) -> int:
        mark = self._marks.get(action.number)
        if mark is None:
            raise InputError(f"there is no onset {action.number}: load the page again")
        match action.do:
            case "accept":
                self._marks[mark.number] = replace(mark, status=Status.ACCEPTED)
            case "reject":
                self._marks[mark.number] = replace(mark, status=Status.REJECTED)
            case "move":
                at = self._inside(mark, action.sample)
                self._marks[mark.number] = replace(mark, sample=at, status=Status.ACCEPTED)
            case "add":
                if len(self._marks) >= MOST:
                    raise InputError(
                        f"there are {MOST} onsets, and a page cannot hold more: label the "
                        "recordings in several commands"
                    )
                at = self._inside(mark, action.sample)
                number = max(self._marks) + 1
                self._marks[number] = replace(
                    mark, number=number, sample=at, found=None, status=Status.ACCEPTED
                )
                return number
            case "label":
                self._runs[mark.number] = action
        return mark.number

    def _inside(self, mark: Mark, sample: int) -> int:
        length = self._lengths[mark.recording][mark.stretch]
        if not 0 <= sample < length:
            raise InputError(
                f"sample {sample} is outside the unbroken signal (0 to {length - 1}): "
                "place the onset within it"
            )
        return sample


def _place(mark: Mark) -> tuple[int, int, int, int]:
    return mark.recording, mark.stretch, mark.sample, mark.number
