"""Checks of values that a caller gave: names, numbers and choices.

Each check returns the value in the one form that the package compares: `Role.TEST` for "test", and
the name "1" for `1`, `1.0`, "01" and " 1 ". Upper and lower case stay.
"""

from __future__ import annotations

import math
import re
import unicodedata
from enum import Enum
from numbers import Real
from typing import Any, TypeVar

from firstcontact.core._errors import ArgumentError
from firstcontact.core.records import LONGEST_NAME
from firstcontact.core.text import check_text

Choice = TypeVar("Choice", bound=Enum)

#: Characters that nobody sees: soft hyphen, zero-width space, marks of direction, byte order mark.
_UNSEEN = re.compile("[\u00ad\u200b\u200e\u200f\u2060\ufeff]")
#: Whole numbers, as tables print them.
_WHOLE = re.compile(r"(-?)\+?0*([0-9]+)(?:\.0*)?")
#: Texts that programs print for a missing value.
_MISSING = ("nan", "NaN", "<NA>", "NaT")


def plain_name(text: str) -> str:
    """Return a name in the one spelling that the package compares.

    Invisible characters and special fonts are removed, "1.0" becomes "1", and "nan" becomes "".
    """
    seen = unicodedata.normalize("NFKC", _UNSEEN.sub("", text))
    seen = unicodedata.normalize("NFKC", " ".join(_UNSEEN.sub("", seen).split()))
    number = _WHOLE.fullmatch(seen)
    return "" if seen in _MISSING else "".join(number.groups()) if number else seen


def given_name(value: Any, parameter: str) -> str:
    """Return a caller's name, which may be a number, as :func:`plain_name`. None and NaN give "".

    Raises ArgumentError for another type and for a name that is too long.
    """
    if value is None or is_number(value) or str(value) in _MISSING:
        value = "" if value is None else str(value)
    check_text(value, parameter)
    name = plain_name(value)
    if len(name) > LONGEST_NAME:
        message = f"the name has {len(name)} characters: give at most {LONGEST_NAME}"
        raise ArgumentError(message, parameter=parameter)
    return name


def given_number(value: Any, parameter: str, low: float, high: float, remedy: str = "") -> float:
    """Return a number as float. Raise ArgumentError unless it is from ``low`` to ``high``."""
    if is_number(value) and low <= value <= high:
        return float(value)
    message = f"{brief(value)} is outside the range: give {remedy or f'{low:g} to {high:g}'}"
    raise ArgumentError(message, parameter=parameter)


def given_whole(value: Any, parameter: str) -> int:
    """Return a whole number, such as 3.0, as int. Raise ArgumentError for any other value."""
    if type(value) is int:
        return value
    if is_number(value) and math.isfinite(value) and value == int(value):
        return int(value)
    raise ArgumentError(f"{brief(value)} is not a whole number: give one", parameter=parameter)


def given_choice(kind: type[Choice], value: Any, parameter: str) -> Choice:
    """Return the member of the enumeration ``kind`` that a value or text states.

    Raises ArgumentError, which lists the members, for any other value.
    """
    try:
        return kind(value.strip().lower() if isinstance(value, str) else value)
    except ValueError:
        choices = ", ".join(f"{kind.__name__}.{member.name}" for member in kind)
        message = f"{brief(value)} is not a {kind.__name__}: give one of {choices}"
        raise ArgumentError(message, parameter=parameter) from None


def is_number(value: Any) -> bool:
    """Return True for a real number. The values True and False are not numbers."""
    return isinstance(value, Real) and not isinstance(value, bool)


def brief(value: object, most: int = 60) -> str:
    """Return the ``repr`` of a value for an error message, cut to ``most`` characters."""
    try:
        text = repr(value)
    except ValueError:  # Python refuses to print numbers of thousands of digits
        text = "a number of thousands of digits"
    return text if len(text) <= most else f"{text[: most - 3]}..."
