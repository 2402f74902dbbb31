"""Lines of numbers, as most sketches print them, as samples: no port in it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from firstcontact.core import InputError, parse_float

#: Names of a column that counts the samples.
COUNTERS = ("counter", "count", "sample", "n", "i", "index", "nr", "#")
#: Names of columns that tell the time, and are neither signal nor count.
TIMES = ("t", "time", "ms", "us", "millis", "micros", "timestamp")
#: Longest line, bytes: what is longer is none.
LONGEST = 1000
#: Lines that must agree on how many columns there are before one is believed.
BELIEVED = 20
#: Counts that go on by more than this from line to line are damaged, or another count.
LEAP = 100_000.0
#: Most columns.
MOST = 64


@dataclass(frozen=True, slots=True)
class Columns:
    """Which column is what.

    Parameters
    ----------
    names
        Of the signals, as the header has them, else their positions.
    signals
        Positions of the columns that are given as samples, at most two.
    counter
        Position of the column that counts samples; None without one.
    width
        Columns of a line.
    """

    names: tuple[str, ...]
    signals: tuple[int, ...]
    counter: int | None
    width: int


@dataclass(slots=True)
class LineReader:
    """Takes bytes as they come; gives the numbers of each whole line.

    Attributes
    ----------
    bad
        Lines that were no numbers, or had another number of columns.
    header
        Names of columns, where the board printed them.
    """

    bad: int = 0
    header: tuple[str, ...] = ()
    _rest: bytes = b""
    _begun: bool = False
    _headers: int = field(default=0)

    def feed(self, data: bytes) -> list[tuple[float, ...] | None]:
        """Numbers of the lines that these bytes complete; None for one that is none.

        The first line is left out: it may have begun before it was listened to.
        """
        pieces = (self._rest + data).replace(b"\r", b"\n").split(b"\n")
        self._rest = pieces.pop()
        if len(self._rest) > LONGEST:  # another baud rate, or no text at all
            self._rest, self._begun = b"", False
            self.bad += 1
        found: list[tuple[float, ...] | None] = []
        for piece in pieces:
            if not self._begun:
                self._begun = True
                self._name(piece)
            elif piece.strip():
                found.append(self._numbers(piece))
        return found

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
            self._headers += 1

    @staticmethod
    def _is_header(words: tuple[str, ...]) -> bool:
        """Whether these are names: short, printable, and each begins with a letter."""
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


def place_of(word: str, names: Sequence[str]) -> int | None:
    """Return the place of a column by its name, or by its position from 1 on; None without one."""
    if word in names:
        return names.index(word)
    positions = [str(k + 1) for k in range(len(names))]
    return positions.index(word) if word in positions else None


def distinct_names(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names, each that is there twice with its position behind it."""
    distinct = [f"{n} {k + 1}" if names.count(n) > 1 else n for k, n in enumerate(names)]
    if len(set(distinct)) < len(distinct):
        distinct = [str(k + 1) for k in range(len(names))]
    return tuple(distinct)


def columns_of(
    lines: list[tuple[float, ...]], header: tuple[str, ...], wanted: tuple[str, ...], port: str
) -> Columns:
    """Which column is what, from the first lines of a board.

    Parameters
    ----------
    lines
        Their numbers.
    header
        Names, where the board printed them.
    wanted
        Signals that a person named, by header or position from 1 on; none for all.
    port
        For messages.

    Raises
    ------
    InputError
        Lines of different lengths, a column that is not there, or more than two signals.
    """
    widths = [len(line) for line in lines]
    width = max(set(widths), key=widths.count)
    alike = [line for line in lines if len(line) == width]
    if len(alike) < 0.8 * len(lines):
        raise InputError(
            f"{port}: its lines have from {min(widths)} to {max(widths)} numbers: have the board "
            "print as many in each, or set its baud rate (csv:PORT@BAUD)"
        )
    named = len(header) == width
    names = distinct_names(header) if named else tuple(str(k + 1) for k in range(width))
    counter = _counter(alike, names if named else ())
    if counter is not None and not _counts(alike, counter):
        raise InputError(
            f"{port}: column {names[counter]!r} is called a counter and does not count up: give it "
            "another name, or have the board count its samples in it"
        )
    if wanted:
        places = []
        for name in wanted:
            place = place_of(name, names)
            if place is None:
                raise InputError(f"{port} has no column {name!r}: choose one of {', '.join(names)}")
            places.append(place)
    else:
        told = {k for k, n in enumerate(names) if n.lower() in TIMES}
        places = [k for k in range(width) if k != counter and k not in told]
    if not 1 <= len(set(places)) == len(places) <= 2:
        raise InputError(
            f"{port} has {len(places)} columns of signals: name one or two of "
            f"{', '.join(names)}, as in csv:PORT#{names[-1]}"
        )
    return Columns(tuple(names[k] for k in places), tuple(places), counter, width)


def _counter(lines: list[tuple[float, ...]], names: tuple[str, ...]) -> int | None:
    """The column that counts: by its name, else the one that rises by 1 from line to line."""
    for k, name in enumerate(names):
        if name.lower() in COUNTERS:
            return k
    for k in range(len(lines[0]) if not names and len(lines[0]) > 1 else 0):
        steps = [b[k] - a[k] for a, b in itertools.pairwise(lines)]
        if steps and steps.count(1.0) > 0.8 * len(steps):
            return k
    return None


def _counts(lines: list[tuple[float, ...]], place: int) -> bool:
    """Return True if a column goes up by no more than a counter can from line to line."""
    steps = [b[place] - a[place] for a, b in itertools.pairwise(lines)]
    return sum(0 < step <= LEAP for step in steps) >= 0.8 * len(steps)
