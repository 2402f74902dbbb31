"""Parsers for numbers in text that people write.

Python's own parsers also accept ``1_000`` and digits of any script; these parsers refuse both.
"""

from __future__ import annotations

import math


def parse_float(text: str, *, finite: bool = True) -> float:
    """Return the number in a text.

    Parameters
    ----------
    text
        Digits, at most one decimal point, and an optional exponent.
    finite
        True to refuse infinity and NaN.

    Raises
    ------
    ValueError
        The text is not such a number. The message is a relative clause for the caller's sentence:
        "which is not a number".
    """
    try:
        value = float(_plain_digits(text))
    except ValueError:
        raise ValueError("which is not a number") from None
    if finite and not math.isfinite(value):
        raise ValueError("which is not a finite number")
    return value


def parse_int(text: str) -> int:
    """Return the whole number in a text without a decimal point.

    Raises
    ------
    ValueError
        The text is not a whole number. The message is a relative clause, as in :func:`parse_float`.
    """
    try:
        return int(_plain_digits(text))
    except ValueError:
        raise ValueError("which is not a whole number") from None


def _plain_digits(text: str) -> str:
    if "_" in text or not text.isascii():
        raise ValueError
    return text
