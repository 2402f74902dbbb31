"""Reader of the lines that a board prints: samples, column names, text, and damaged lines."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from firstcontact.core.text import parse_float

#: Longest line, bytes. Longer ones are discarded.
LONGEST = 1000
#: Largest number of columns.
MOST = 64
#: Start of a line of text. It has words, perhaps after a sign or one number.
_TEXT = re.compile(r"\W*(?:[\d.:+-]+[\])]?\s+)?[A-Za-z](?:[A-Za-z]|\b)")


@dataclass(slots=True)
class LineReader:
    """Reader that turns a board's bytes into the numbers of each complete line.

    ``bad`` counts damaged lines. ``header`` holds the column names that the board printed, or ().
    """

    bad: int = 0
    header: tuple[str, ...] = ()
    _rest: bytes = b""
    _begun: bool = False
    _last_names: tuple[str, ...] = ()
    _plots: bool = False
    _usual: tuple[int, ...] = ()
    _width: int = 0

    def restart(self) -> None:
        """Forget an incomplete line. Call it after the port was opened again."""
        self._rest, self._begun = b"", False

    def feed(self, data: bytes) -> list[tuple[float, ...] | None]:
        """Process the next bytes. Return the numbers of each complete line, None for a damaged one.

        Lines of text are left out.
        """
        pieces = (self._rest + data).replace(b"\r", b"\n").split(b"\n")
        self._rest = pieces.pop()
        if len(self._rest) > LONGEST:  # wrong baud rate, or no text
            self._rest, self._begun = b"", False
            self.bad += 1
        lines: list[tuple[float, ...] | None] = []
        for piece in pieces:
            if not self._begun:
                self._begun = True
                self._store_names(piece)
            elif piece.strip() and not self._is_text(piece):
                lines.append(self._numbers(piece))
        return lines

    def _is_text(self, line: bytes) -> bool:
        """Return True for a line of text, False for a line with a sample.

        A line for a plotter, such as "x:1.2 y:3.4", has a sample. Column names are stored.
        """
        text, words = line.decode("ascii", "replace").strip(), _words(line)
        names, values = _names_and_values(words)
        is_usual = self._usual == _separator_counts(line)
        if names and all(names) and all(map(_is_number, values)):
            # A plotter's line, if another one with these names came before: "vbat:3.71" may be text
            is_known = names in (self.header, self._last_names)
            self._last_names, self.header = names, names if is_known else self.header
            self._plots |= is_known
            return not is_known and not (self._plots and is_usual)
        self._last_names = ()
        is_words = text.isascii() and text.isprintable() and _TEXT.match(text)
        if not is_words or all(map(_is_number, words)):
            return False
        if is_usual and (any(map(_is_number, values)) or (self._plots and all(names))):
            return False  # a damaged sample
        self._store_names(line)
        return True

    def _numbers(self, line: bytes) -> tuple[float, ...] | None:
        names, texts = _names_and_values(_words(line))
        try:
            values = tuple(parse_float(text, finite=False) for text in texts)
        except ValueError:
            values = ()
        is_damaged = not values or len(values) > MOST or not all(map(math.isfinite, values))
        if is_damaged or (self._plots and any(names) and names != self.header):
            self.bad += 1
            return None
        self._usual, self._width = _separator_counts(line), len(values)
        return values

    def _store_names(self, line: bytes) -> None:
        """Store the words of a line as column names. Ignore words that cannot be names.

        After the first sample, only the former names, in another order, can replace them.
        """
        words, former = _words(line), self.header
        fits = len(words) > 1 or len(former) < 2
        if self._usual:
            is_other = len(former) == self._width and set(words) != set(former)
            fits = len(words) == self._width and not is_other
        if fits and self._is_header(words):
            self.header = words

    @staticmethod
    def _is_header(words: tuple[str, ...]) -> bool:
        """Return True if all words can be column names: short, in ASCII, and without "=?!"."""
        return 0 < len(words) <= MOST and all(
            w.isprintable()
            and w.isascii()
            and len(w) <= 40
            and (w[0].isalpha() or w == "#")
            and not set(w) & set("=?!")
            for w in words
        )


def _names_and_values(words: tuple[str, ...]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Split words such as "x:1.2" at the colon. Return the names and the values, as texts.

    A word without a colon has the name "".
    """
    parts = [word.rpartition(":") for word in words]
    return tuple(name for name, _, _ in parts), tuple(value for _, _, value in parts)


def _separator_counts(line: bytes) -> tuple[int, ...]:
    """Return the numbers of commas, semicolons and tabs in a line.

    If there are none of these, return only the number of words.
    """
    counts = tuple(line.count(separator) for separator in (b",", b";", b"\t"))
    return counts if any(counts) else (len(_words(line)),)


def _is_number(word: str) -> bool:
    try:
        parse_float(word, finite=False)
    except ValueError:
        return False
    return True


def _words(line: bytes) -> tuple[str, ...]:
    text = line.decode("ascii", "replace").strip().lstrip("# ") or line.decode("ascii", "replace")
    for separator in (",", ";", "\t"):
        if separator in text:
            return tuple(w.strip() for w in text.split(separator) if w.strip())
    return tuple(text.split())
