"""Names as text in figures: nothing in them is markup, and nothing stops a drawing."""

from __future__ import annotations

import unicodedata
from functools import lru_cache
from typing import Any

#: For :func:`matplotlib.rc_context` around all that draws: a dollar sign is a dollar sign.
PLAIN: Any = {"text.parse_math": False, "text.usetex": False, "font.family": "DejaVu Sans"}
#: Longer names are cut.
MOST = 28


def figure_label(name: str, most: int = MOST) -> str:
    """A name from a recording as it is written in a figure.

    On one line and of bounded length. A character that the font of the figures has not, or
    whose glyph means something to the font's makers only, is given by its number, as U+82F9;
    the report's tables have the name itself.

    Parameters
    ----------
    name
        Any text.
    most
        Characters of it that are kept.
    """
    there = _glyphs()
    line = " ".join("".join(_printable(c) for c in name[: 4 * most]).split())
    out = ""
    for character in line:
        known = ord(character) in there and character.isprintable()
        written = character if known else f"U+{ord(character):04X}"
        if len(out) + len(written) > most:
            return f"{out[: most - 1]}…"
        out += written
    return f"{out[: most - 1]}…" if len(name) > 4 * most else out


def _printable(character: str) -> str:
    kind = unicodedata.category(character)
    if kind in ("Zl", "Zp", "Zs") or character.isspace():
        return " "
    # Controls, halves of surrogate pairs, and what only directs text or joins characters.
    return "\N{REPLACEMENT CHARACTER}" if kind in ("Cc", "Cs", "Cf") else character


@lru_cache(maxsize=1)
def _glyphs() -> frozenset[int]:
    """Characters that the figures' font has."""
    from matplotlib.font_manager import findfont, get_font

    return frozenset(get_font(findfont(PLAIN["font.family"])).get_charmap())
