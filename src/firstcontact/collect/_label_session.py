"""One labelling: what the page is told and asks for."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from msgspec import Meta

from firstcontact.collect._label_journal import Journal, Opened
from firstcontact.collect._label_marks import Action, Mark, Marks, Whole
from firstcontact.collect._label_result import By, write_labelled
from firstcontact.collect._label_signals import WIDEST, about, find_marks, piece
from firstcontact.core import InputError, read_record
from firstcontact.recording import Recording

#: Longest message of the page, bytes.
LONGEST = 4096
#: What changes one mark only, so that the others need not be told again.
_OF_ONE = ("accept", "reject", "move")
#: The field that only a question has: an object may have that name, too.
_QUESTION = re.compile(rb'"ask"\s*:')


@dataclass(frozen=True, slots=True)
class _Asked:
    """A piece of signal around a sample."""

    ask: Literal["signal", "finish"]
    number: Whole = 0
    recording: Whole = 0
    stretch: Whole = 0
    sample: Whole = 0
    half: Annotated[float, Meta(gt=0.0, le=WIDEST)] = 0.02


class Session:
    """Marks of some recordings, kept in a journal, and written when all is done.

    Parameters
    ----------
    recordings
        What is labelled.
    out
        Folder for the new recordings and the journal.
    by
        Who labels, when and with what.
    is_new_allowed
        Whether a folder without labels is begun; otherwise it is refused and stays as it is.

    Raises
    ------
    InputError
        No onsets are found, a new recording is there already, or the journal cannot be used.
    """

    def __init__(
        self, recordings: Sequence[Recording], out: Path, by: By, is_new_allowed: bool = True
    ) -> None:
        self._recordings = list(recordings)
        self._by = by
        self._paths = [out / r.path.name for r in recordings]
        there = next((p for p in self._paths if p.exists()), None)
        if there is not None:
            raise InputError(
                f"{there} is there and recordings are never overwritten: choose another --out"
            )
        found = find_marks(recordings)
        self.marks = Marks(found, [[len(s.data) for s in r.stretches] for r in recordings])
        try:
            if is_new_allowed:
                out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{out} cannot be made ({error.strerror}): choose another") from error
        self._journal = Journal(
            out / "labels.jsonl",
            Opened(tuple(r.path.name for r in recordings), len(found)),
            is_new_allowed,
        )
        try:
            for action in self._journal.actions:
                self.marks.act(action)
        except InputError as error:
            self._journal.close()
            raise InputError(
                f"{self._journal.path} tells of what is not there ({error}): remove it to begin "
                "anew, or choose another --out"
            ) from error
        #: What was written, once all is done.
        self.written: list[Path] = []

    @property
    def earlier(self) -> str:
        """What is there of earlier sessions, in words."""
        lost = self._journal.lost_bytes
        damage = f" ({self._journal.path} ends in {lost} bytes that are no label)" if lost else ""
        return f"{len(self._journal.actions)} actions done before{damage}"

    def now(self) -> dict[str, Any]:
        """All marks as they are."""
        return {
            "marks": [_told(mark) for mark in self.marks.ordered()],
            "done": len(self.marks.done),
        }

    def hello(self) -> dict[str, Any]:
        """All that the page starts with."""
        return {"recordings": about(self._recordings), **self.now()}

    def obey(self, message: str | bytes) -> dict[str, Any]:
        """Do what the page asks, and answer with what is new.

        Raises
        ------
        InputError
            It cannot be done; nothing has changed.
        """
        data = message.encode() if isinstance(message, str) else message
        if _QUESTION.search(data):
            return self._ask(read_record(data, _Asked, "the page", "load it again", LONGEST))
        action = read_record(data, Action, "the page", "load it again", LONGEST)
        before = list(self.marks.done)
        number = self.marks.act(action)
        try:
            self._journal.add(action)
        except InputError:
            self.marks.again(before)
            raise
        if action.do not in _OF_ONE:
            return {**self.now(), "at": number}
        (mark,) = (m for m in self.marks.ordered() if m.number == action.number)
        return {"mark": _told(mark), "done": len(self.marks.done)}

    def finish(self) -> list[str]:
        """Write the new recordings, and say what is in them.

        Raises
        ------
        InputError
            One cannot be written, or nothing is labelled: none is there then, and the labelling
            can go on.
        """
        if not self.marks.done:
            raise InputError("nothing is labelled yet: accept or reject an onset first")
        said = []
        written: list[Path] = []
        ordered = self.marks.ordered()
        try:
            for number, recording in enumerate(self._recordings):
                path = self._paths[number]
                its = [m for m in ordered if m.recording == number]
                pinches, left = write_labelled(recording, its, path, self._by)
                written.append(path)
                rest = f"; {left} onsets were not looked at" if left else ""
                said.append(f"{path}: {pinches} pinches{rest}")
        except BaseException:
            for path in written:
                path.unlink(missing_ok=True)
            raise
        self.written = written
        return said

    def close(self) -> None:
        """Let the journal go. Closing twice is fine."""
        self._journal.close()

    def _ask(self, asked: _Asked) -> dict[str, Any]:
        if asked.ask == "finish":
            return {"finished": self.finish()}
        if asked.recording >= len(self._recordings) or asked.stretch >= len(
            self._recordings[asked.recording].stretches
        ):
            raise InputError("there is no such recording: load the page again")
        recording = self._recordings[asked.recording]
        its = piece(recording, asked.stretch, asked.sample, asked.half)
        return {
            "signal": {**its, "number": asked.number, "asked": asked.sample, "half": asked.half}
        }


def _told(mark: Mark) -> dict[str, Any]:
    return asdict(mark)
