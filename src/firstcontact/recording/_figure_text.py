"""Names as plain text in figures, without markup and in characters that the font has."""

from __future__ import annotations

import unicodedata
from functools import lru_cache
from typing import Any

#: Settings for :func:`matplotlib.rc_context` that draw text literally, dollar signs included.
PLAIN: Any = {"text.parse_math": False, "text.usetex": False, "font.family": "DejaVu Sans"}
#: Longest name in a figure; longer ones are cut.
MOST = 28


def figure_label(name: str, most: int = MOST) -> str:
    """Return a name from a recording as text for a figure.

    The text has one line and bounded length. A character that the font lacks, or that is in
    Unicode's private area, becomes a number such as U+82F9. The report's tables show the original
    name.

    Parameters
    ----------
    name
        Any text.
    most
        Largest number of characters.
    """
    glyphs = _glyphs()
    line = " ".join("".join(_printable(c) for c in name[: 4 * most]).split())
    out = ""
    for character in line:
        is_drawable = ord(character) in glyphs and character.isprintable()
        written = character if is_drawable else f"U+{ord(character):04X}"
        if len(out) + len(written) > most:
            return f"{out[: most - 1]}…"
        out += written
    return f"{out[: most - 1]}…" if len(name) > 4 * most else out


def _printable(character: str) -> str:
    kind = unicodedata.category(character)
    if kind in ("Zl", "Zp", "Zs") or character.isspace():
        return " "
    # Control characters, surrogates, and characters that only direct or join text.
    return "\N{REPLACEMENT CHARACTER}" if kind in ("Cc", "Cs", "Cf") else character


@lru_cache(maxsize=1)
def _glyphs() -> frozenset[int]:
    """Return the characters that the figures' font has."""
    from matplotlib.font_manager import findfont, get_font

    return frozenset(get_font(findfont(PLAIN["font.family"])).get_charmap())
