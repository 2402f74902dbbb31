"""What was done, line by line on the disk: nothing that was said is lost with a crash."""

from __future__ import annotations

import fcntl
import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO

from firstcontact.collect._label_marks import Action
from firstcontact.core import InputError, read_record, read_regular

#: Most bytes of a journal that is read.
LONGEST = 1 << 27


@dataclass(frozen=True, slots=True)
class Opened:
    """The first line: what is labelled, so that a journal is never taken for another's."""

    labelling: tuple[str, ...]
    found: int


class Journal:
    """Appends each action and hands it to the disk before it is answered.

    Parameters
    ----------
    path
        The file; one that is there is gone on with.
    opened
        What is labelled.
    is_new_allowed
        Whether a file without actions is begun; otherwise it is refused and stays as it is.

    Attributes
    ----------
    actions
        Actions of earlier sessions.
    lost_bytes
        Length of an unreadable end, which a crash or a power cut leaves. It is not used, and the
        next action replaces it.

    Raises
    ------
    InputError
        The file is of other recordings, is damaged, cannot be read or not be written, or another
        command has it.
    """

    def __init__(self, path: Path, opened: Opened, is_new_allowed: bool = True) -> None:
        self.path = path
        self.actions: list[Action] = []
        self.lost_bytes = 0
        #: Where the next line goes: what a crash cut off stays until there is one.
        self._end = 0
        there = path.exists()
        if there:
            self._read(opened)
        if not self.actions and not is_new_allowed:
            raise InputError(
                f"{path} holds no labels, so there is nothing to write: label on the page first"
            )
        try:
            # What could not be written must not wait in a buffer: it would be at the end.
            self._stream: IO[bytes] = path.open("r+b" if there else "xb", buffering=0)
        except OSError as error:
            raise self._failed(error) from error
        try:
            self._take()
            if there:  # again: who had it until now may have gone on
                self._end = self._read(opened)
            if not self._end:
                self._append(opened)
        except BaseException:
            self._stream.close()
            raise

    def add(self, action: Action) -> None:
        """Append an action."""
        self._append(action)

    def close(self) -> None:
        """Close the file; twice is fine."""
        self._stream.close()

    def _append(self, entry: Opened | Action) -> None:
        try:
            self._stream.truncate(self._end)
            self._stream.seek(self._end)
            rest = memoryview(_line(entry))
            while rest:
                rest = rest[self._stream.write(rest) :]
            os.fsync(self._stream.fileno())
            self._end = self._stream.tell()
        except OSError as error:
            raise self._failed(error) from error

    def _take(self) -> None:
        """Keep other commands from it until it is closed."""
        try:
            fcntl.flock(self._stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(
                f"{self.path} is written by another firstcontact label: end that one, or choose "
                "another --out"
            ) from None
        except OSError:
            return  # a disk without locks

    def _read(self, opened: Opened) -> int:
        """Read the actions of earlier sessions and return where the last whole line ends."""
        try:
            raw = read_regular(self.path, LONGEST)
        except OSError as error:
            raise self._failed(error) from error
        end = raw.rfind(b"\n") + 1
        remedy = "remove it to begin anew, or choose another --out"
        if not end:
            # A crash can cut off the first line. A power cut can leave zeros instead of labels.
            if not _line(opened).startswith(raw):
                raise InputError(
                    f"{self.path} is damaged, none of its {len(raw)} bytes can be read: {remedy}"
                )
            return 0
        first, *lines = raw[:end].splitlines()
        if read_record(first, Opened, f"{self.path}: line 1", remedy) != opened:
            raise InputError(
                f"{self.path} is of other recordings, or of onsets that were found otherwise: "
                f"{remedy}"
            )
        remedy = "remove this line and all behind it to keep the labels before it"
        self.actions = [
            read_record(line, Action, f"{self.path}: line {number}", remedy)
            for number, line in enumerate(lines, 2)
        ]
        self.lost_bytes = len(raw) - end
        return end

    def _failed(self, error: OSError) -> InputError:
        return InputError(
            f"{self.path} cannot be written ({error.strerror}): what was said before is in it; "
            "make room and give the same command again"
        )


def _line(entry: Opened | Action) -> bytes:
    """Return an entry of the journal as JSON with its line end."""
    return json.dumps(asdict(entry), ensure_ascii=False).encode() + b"\n"
