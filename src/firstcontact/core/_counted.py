"""Numbers with their nouns, as they are read: 1 pinch, 2 pinches."""

from __future__ import annotations

#: Endings that take -es; an epoch does not.
_ES = ("s", "x", "nch", "tch", "sh")


def counted(number: int, noun: str) -> str:
    """The number with its noun: "1 pinch", "1,200 channels"; of one word or several.

    Parameters
    ----------
    number
        Of the things.
    noun
        Of one of them, regular: what takes -s or -es.
    """
    return f"{number:,} {nouns(number, noun)}"


def nouns(number: int, noun: str) -> str:
    """The noun alone, as it stands behind that number."""
    if number == 1:
        return noun
    if noun.endswith("y") and noun[-2:-1] not in "aeiou":
        return noun[:-1] + "ies"
    return noun + ("es" if noun.endswith(_ES) else "s")
