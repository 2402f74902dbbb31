"""Parsers of single table cells. They raise ValueError with the reason."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any, TypeVar

import numpy as np

from firstcontact.core import (
    FASTEST,
    HIGHEST_RANK,
    LONGEST_NAME,
    SLOWEST,
    Finger,
    InputError,
    Role,
    parse_float,
)
from firstcontact.recording._quoting import as_text, quote
from firstcontact.recording._table import Table

#: Names of hardness classes, from soft to hard.
CLASSES = ("soft", "medium", "hard")

T = TypeVar("T")
Columns = Mapping[str, Sequence[Any]]


def place(columns: Columns, number: int) -> str:
    """Return the place of a pinch's labels (line or array index), for messages."""
    return columns.place(number) if isinstance(columns, Table) else f"pinch {number}"


def each(place_name: str, columns: Columns, name: str, read: Callable[[Any], T]) -> list[T] | None:
    """Return the parsed values of a column; None if the column does not exist."""
    if name not in columns:
        return None
    values = []
    for i, value in enumerate(columns[name]):
        try:
            values.append(read(value))
        except (ValueError, TypeError, OverflowError) as error:
            raise InputError(
                f"{place_name}: '{name}' of {place(columns, i)} is {quote(value)}, {error}: "
                f"correct it, or leave '{name}' out for all pinches"
            ) from None
    return values


def words(value: Any) -> str:
    """Parse text, which may be empty."""
    if isinstance(value, np.void | np.ndarray):  # a NumPy record, or untyped bytes
        raise ValueError("which is neither a text nor a number")
    if isinstance(value, float | np.floating) and value.is_integer():
        value = int(value)  # MATLAB stores whole numbers as floats
    text = as_text(value).strip()
    if len(text) > LONGEST_NAME:
        raise ValueError(f"which is longer than {LONGEST_NAME} characters")
    return text


def name(value: Any) -> str:
    """Parse a name."""
    text = words(value)
    if text in ("", "nan"):
        raise ValueError("which is empty")
    return text


def number(value: Any) -> float:
    """Parse a finite number."""
    return parse_float(as_text(value))


def integer(value: Any) -> int:
    """Parse a whole number."""
    parsed = number(value)
    if parsed != int(parsed):
        raise ValueError("which is not a whole number")
    return int(parsed)


def ranked(value: Any) -> int:
    """Parse a hardness rank."""
    parsed = integer(value)
    if abs(parsed) > HIGHEST_RANK:
        raise ValueError(f"which is beyond the highest rank {HIGHEST_RANK}")
    return parsed


def shore(value: Any) -> float:
    """Parse a Shore A value."""
    parsed = number(value)
    if not 0 <= parsed <= 100:
        raise ValueError("which is outside Shore A 0 to 100")
    return parsed


def speed(value: Any) -> float:
    """Parse a closing speed in m/s; -1 means unknown."""
    return _speed(value, SLOWEST)


def speed_error(value: Any) -> float:
    """Parse the standard error of a closing speed in m/s; -1 means an unknown speed."""
    return _speed(value, 0.0)


def _speed(value: Any, least: float) -> float:
    parsed = number(value)
    if parsed != -1 and not least <= parsed <= FASTEST:
        raise ValueError(f"which is neither {least:g} to {FASTEST:g} m/s nor -1 for unknown")
    return parsed


def rank(value: Any) -> int:
    """Parse a hardness class or a hardness rank. Return the rank."""
    text = as_text(value).strip().lower()
    if text in CLASSES:
        return CLASSES.index(text)
    try:
        return ranked(text)
    except ValueError:
        raise ValueError(f"which is neither {', '.join(CLASSES)} nor a whole number") from None


def role(value: Any) -> Role:
    """Parse the role of a pinch."""
    try:
        return Role(as_text(value).strip().lower())
    except ValueError:
        raise ValueError("which is not a role (train or test)") from None


def finger(value: Any) -> Finger | None:
    """Parse a finger. Return None if it is unknown."""
    text = as_text(value).strip().lower()
    with suppress(ValueError):
        text = str(integer(text))
    for one in Finger:
        if text in (str(int(one)), one.name.lower()):
            return one
    if text in ("", "-1"):
        return None
    raise ValueError("which is neither index (0) nor thumb (1)")
