"""What was done, line by line on the disk: nothing that was said is lost with a crash."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO

from firstcontact.core import InputError
from firstcontact.core.files import read_regular
from firstcontact.core.records import read_record
from firstcontact.labelling._marks import Action

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

    Raises
    ------
    InputError
        The file is of other recordings, cannot be read or not be written.
    """

    def __init__(self, path: Path, opened: Opened) -> None:
        self.path = path
        self.actions: list[Action] = []
        #: Where the next line goes: what a crash cut off stays until there is one.
        self._end = self._read(opened) if path.exists() else 0
        try:
            self._stream: IO[bytes] = path.open("r+b" if self._end else "wb")
        except OSError as error:
            raise self._failed(error) from error
        if not self._end:
            self._append(asdict(opened))

    def add(self, action: Action) -> None:
        """Append an action."""
        self._append(asdict(action))

    def close(self) -> None:
        """Close the file; twice is fine."""
        self._stream.close()

    def _append(self, tree: object) -> None:
        try:
            self._stream.truncate(self._end)
            self._stream.seek(self._end)
            self._stream.write(json.dumps(tree, ensure_ascii=False).encode() + b"\n")
            self._stream.flush()
            self._end = self._stream.tell()
            os.fsync(self._stream.fileno())
        except OSError as error:
            raise self._failed(error) from error

    def _read(self, opened: Opened) -> int:
        """Take in what was done before; where the last whole line ends."""
        try:
            raw = read_regular(self.path, LONGEST)
        except OSError as error:
            raise self._failed(error) from error
        # A line that a crash cut off was never answered: it is written over.
        end = raw.rfind(b"\n") + 1
        lines: Sequence[bytes] = raw[:end].splitlines()
        if not lines:
            return 0
        remedy = "remove it to begin anew, or choose another --out"
        first = read_record(lines[0], Opened, f"{self.path}: line 1", remedy)
        if first != opened:
            raise InputError(
                f"{self.path} is of other recordings, or of onsets that were found otherwise: "
                f"{remedy}"
            )
        self.actions = [
            read_record(line, Action, f"{self.path}: line {number}", remedy)
            for number, line in enumerate(lines[1:], 2)
        ]
        return end

    def _failed(self, error: OSError) -> InputError:
        return InputError(
            f"{self.path} cannot be written ({error.strerror}): what was said before is in it; "
            "make room and give the same command again"
        )
