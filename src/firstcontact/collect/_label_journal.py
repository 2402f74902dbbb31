"""Journal of a labelling: each action is written to disk as a line, so that a crash loses none."""

from __future__ import annotations

import fcntl
import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO

from firstcontact.collect._label_marks import Action
from firstcontact.core import InputError, read_record, read_regular

#: Largest journal, bytes.
LONGEST = 1 << 27


@dataclass(frozen=True, slots=True)
class Opened:
    """First line of a journal: the names of the recordings and the number of onsets."""

    labelling: tuple[str, ...]
    found: int


class Journal:
    """File to which each action is appended before the page gets its reply."""

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
            raise InputError(
                f"{path} holds no labels, so there is nothing to write: label on the page first"
            )
        try:
            # Without a buffer, which would keep bytes that could not be written.
            self._stream: IO[bytes] = path.open("r+b" if is_there else "xb", buffering=0)
        except OSError as error:
            raise self._failed(error) from error
        try:
            self._take()
            if is_there:  # read again: the last command with the lock may have written
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
        """Close the file. Closing twice is fine."""
        self._stream.close()

    def _append(self, entry: Opened | Action) -> None:
        try:
            self._stream.truncate(self._end)
            self._stream.seek(self._end)
            unwritten = memoryview(_line(entry))
            while unwritten:
                unwritten = unwritten[self._stream.write(unwritten) :]
            os.fsync(self._stream.fileno())
            self._end = self._stream.tell()
        except OSError as error:
            raise self._failed(error) from error

    def _take(self) -> None:
        """Lock the file against other commands until it is closed."""
        try:
            fcntl.flock(self._stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(
                f"{self.path} is in use by another `firstcontact label`: end that command, or "
                "choose another folder"
            ) from None
        except OSError:
            return  # a disk without locks

    def _read(self, opened: Opened) -> int:
        """Read the actions in the file. Return the position at which its last whole line ends."""
        try:
            raw = read_regular(self.path, LONGEST)
        except OSError as error:
            raise self._failed(error) from error
        end = raw.rfind(b"\n") + 1
        remedy = "remove it to start again, or choose another folder"
        if not end:
            # A crash can cut off the first line. A power cut can leave zeros instead of labels.
            if not _line(opened).startswith(raw):
                raise InputError(
                    f"{self.path} is damaged: none of its {len(raw)} bytes can be read: {remedy}"
                )
            return 0
        first, *lines = raw[:end].splitlines()
        if read_record(first, Opened, f"{self.path}: line 1", remedy) != opened:
            raise InputError(
                f"{self.path} belongs to other recordings, or to other onsets: {remedy}"
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
            f"{self.path} cannot be written ({error.strerror}): your earlier labels are in it; "
            "make room on the disk and run the same command again"
        )


def _line(entry: Opened | Action) -> bytes:
    """Return an entry of the journal as JSON with its line end."""
    return json.dumps(asdict(entry), ensure_ascii=False).encode() + b"\n"
