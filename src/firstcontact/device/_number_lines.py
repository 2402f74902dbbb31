"""Parsing of text lines with numbers, as boards print them, into samples."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

from firstcontact.core import InputError, parse_float

#: Names of a column that counts samples.
COUNTERS = ("counter", "count", "sample", "n", "i", "index", "nr", "#")
#: Names of columns with the time, which are neither signal nor counter.
TIMES = ("t", "time", "ms", "us", "millis", "micros", "timestamp")
#: Order of columns with the name of a finger, before and after other columns.
_FINGERS = {"index": -1, "thumb": 1}
#: Longest line, bytes. Longer ones are discarded.
LONGEST = 1000
#: Number of lines that are needed to identify the columns.
LINES_NEEDED = 20
#: Largest step of a counter between lines. A larger one means damage or a restart.
LEAP = 100_000.0
#: Largest number of columns.
MOST = 64


@dataclass(frozen=True, slots=True)
class Columns:
    """Meaning of the columns of a line."""

    names: tuple[str, ...]
    signals: tuple[int, ...]
    counter: int | None
    width: int


@dataclass(slots=True)
class LineReader:
    """Reader that turns bytes into the numbers of each complete line."""

    bad: int = 0
    header: tuple[str, ...] = ()
    _rest: bytes = b""
    _begun: bool = False

    def feed(self, data: bytes) -> list[tuple[float, ...] | None]:
        """Return the numbers in each line that ``data`` completes."""
        pieces = (self._rest + data).replace(b"\r", b"\n").split(b"\n")
        self._rest = pieces.pop()
        if len(self._rest) > LONGEST:  # wrong baud rate, or no text
            self._rest, self._begun = b"", False
            self.bad += 1
        lines: list[tuple[float, ...] | None] = []
        for piece in pieces:
            if not self._begun:
                self._begun = True
                self._name(piece)
            elif piece.strip():
                lines.append(self._numbers(piece))
        return lines

    def _numbers(self, line: bytes) -> tuple[float, ...] | None:
        words = _words(line)
        try:
            values = tuple(parse_float(w.rpartition(":")[2], finite=False) for w in words)
        except ValueError:
            self._name(line)
            self.bad += not self._is_header(words)
            return None
        if not values or len(values) > MOST or not all(math.isfinite(v) for v in values):
            self.bad += 1
            return None
        if len(self.header) != len(words) and all(
            ":" in w for w in words
        ):  # name:value, for plotters
            self.header = tuple(w.partition(":")[0] for w in words)
        return values

    def _name(self, line: bytes) -> None:
        words = _words(line)
        if self._is_header(words):
            self.header = words

    @staticmethod
    def _is_header(words: tuple[str, ...]) -> bool:
        """Return True if these words can be column names: short ASCII words."""
        return 0 < len(words) <= MOST and all(
            w.isprintable() and w.isascii() and len(w) <= 40 and (w[0].isalpha() or w == "#")
            for w in words
        )


def _words(line: bytes) -> tuple[str, ...]:
    text = line.decode("ascii", "replace").strip().lstrip("# ") or line.decode("ascii", "replace")
    for separator in (",", ";", "\t"):
        if separator in text:
            return tuple(w.strip() for w in text.split(separator) if w.strip())
    return tuple(text.split())


def find_column(word: str, names: Sequence[str]) -> int | None:
    """Return the index of a column from its name or its position from 1; None if missing."""
    if word in names:
        return names.index(word)
    positions = [str(k + 1) for k in range(len(names))]
    return positions.index(word) if word in positions else None


def distinct_names(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names. A name that occurs more than once gets its position appended."""
    distinct = [f"{n} {k + 1}" if names.count(n) > 1 else n for k, n in enumerate(names)]
    if len(set(distinct)) < len(distinct):
        distinct = [str(k + 1) for k in range(len(names))]
    return tuple(distinct)


def identify_columns(
    lines: list[tuple[float, ...]], header: tuple[str, ...], wanted: tuple[str, ...], port: str
) -> Columns:
    """Return the meaning of the columns, from the first lines of a board."""
    widths = [len(line) for line in lines]
    width = max(set(widths), key=widths.count)
    full_lines = [line for line in lines if len(line) == width]
    if len(full_lines) < 0.8 * len(lines):
        raise InputError(
            f"{port}: the lines have from {min(widths)} to {max(widths)} numbers: print the same "
            "number of columns in each line, or set its baud rate (csv:PORT@BAUD)"
        )
    named = len(header) == width
    names = distinct_names(header) if named else tuple(str(k + 1) for k in range(width))
    places = []
    for name in wanted:
        place = find_column(name, names)
        if place is None:
            raise InputError(f"{port} has no column {name!r}: choose one of {', '.join(names)}")
        places.append(place)
    counter = _counter(full_lines, names if named else (), places)
    if counter is not None and not _counts(full_lines, counter):
        raise InputError(
            f"{port}: column {names[counter]!r} has the name of a counter but does not count up: "
            "rename it, let the board count its samples in it, or name it if it is a signal, as in "
            f"csv:PORT#{names[counter]}"
        )
    if not wanted:
        times = {k for k, n in enumerate(names) if n.lower() in TIMES}
        places = [k for k in range(width) if k != counter and k not in times]
    places.sort(key=lambda k: _FINGERS.get(names[k].lower(), 0))
    if not 1 <= len(set(places)) == len(places) <= 2:
        raise InputError(
            f"{port} has {len(places)} columns of signals: name one or two of "
            f"{', '.join(names)}, as in csv:PORT#{names[-1]}"
        )
    return Columns(tuple(names[k] for k in places), tuple(places), counter, width)


def _counter(
    lines: list[tuple[float, ...]], names: tuple[str, ...], signals: Sequence[int]
) -> int | None:
    """Return the counter column: the one with a counter's name, or one that rises by 1 per line."""
    lower = [name.lower() for name in names]
    for k, name in enumerate(lower):
        is_finger = name == "index" and "thumb" in lower and not _counts(lines, k)
        if name in COUNTERS and k not in signals and not is_finger:
            return k
    for k in range(len(lines[0]) if not names and len(lines[0]) > 1 else 0):
        steps = [b[k] - a[k] for a, b in itertools.pairwise(lines)]
        if k not in signals and steps and steps.count(1.0) > 0.8 * len(steps):
            return k
    return None


def _counts(lines: list[tuple[float, ...]], column: int) -> bool:
    """Return True if a column rises in most lines, by at most ``LEAP`` each time."""
    steps = [b[column] - a[column] for a, b in itertools.pairwise(lines)]
    return sum(0 < step <= LEAP for step in steps) >= 0.8 * len(steps)
