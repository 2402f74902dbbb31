"""Lines of a board that prints numbers: samples, text, names of columns, and damage."""

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
    """Reader that turns bytes into the numbers of each complete line."""

    bad: int = 0
    header: tuple[str, ...] = ()
    _rest: bytes = b""
    _begun: bool = False
    _last_names: tuple[str, ...] = ()

    def feed(self, data: bytes) -> list[tuple[float, ...] | None]:
        """Return the numbers of the lines, None for damaged ones; lines of text are left out."""
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
            elif piece.strip() and not self._is_text(piece):
                lines.append(self._numbers(piece))
        return lines

    def _is_text(self, line: bytes) -> bool:
        """Return True for a line of text, which is no sample. Names before numbers are no text."""
        text, words = line.decode("ascii", "replace").strip(), _words(line)
        names = tuple(w.rpartition(":")[0] for w in words)
        if all(names) and all(_is_number(w.rpartition(":")[2]) for w in words):
            # A plotter's line, if another one with these names came before: "vbat:3.71" may be text
            is_known = names in (self.header, self._last_names)
            self._last_names, self.header = names, names if is_known else self.header
            return not is_known
        self._last_names = ()
        is_words = text.isascii() and text.isprintable() and _TEXT.match(text)
        if not is_words or all(map(_is_number, words)):
            return False
        self._name(line)
        return True

    def _numbers(self, line: bytes) -> tuple[float, ...] | None:
        words = _words(line)
        try:
            values = tuple(parse_float(w.rpartition(":")[2], finite=False) for w in words)
        except ValueError:
            self.bad += 1
            return None
        if not values or len(values) > MOST or not all(math.isfinite(v) for v in values):
            self.bad += 1
            return None
        return values

    def _name(self, line: bytes) -> None:
        words = _words(line)
        if self._is_header(words):
            self.header = words

    @staticmethod
    def _is_header(words: tuple[str, ...]) -> bool:
        """Return True if these words can be column names: short ASCII words."""
        return 0 < len(words) <= MOST and all(
            w.isprintable()
            and w.isascii()
            and len(w) <= 40
            and (w[0].isalpha() or w == "#")
            and not set(w) & set("=?!")
            for w in words
        )


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
