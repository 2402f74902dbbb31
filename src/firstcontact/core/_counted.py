"""Numbers with their nouns for messages: 1 pinch, 2 pinches."""

from __future__ import annotations

#: Endings that take -es in the plural ("epoch" does not).
_ES = ("s", "x", "nch", "tch", "sh")


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, singular or plural: "1 pinch", "1,200 channels".

    Parameters
    ----------
    number
        Number that stands before the noun.
    noun
        Noun in the singular, with a regular plural (-s or -es).
    """
    return f"{number:,} {nouns(number, noun)}"


def nouns(number: int, noun: str) -> str:
    """Return the noun without the number, in the singular or plural that fits the number."""
    if number == 1:
        return noun
    if noun.endswith("y") and noun[-2:-1] not in "aeiou":
        return noun[:-1] + "ies"
    return noun + ("es" if noun.endswith(_ES) else "s")
