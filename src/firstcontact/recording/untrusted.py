"""Helpers for untrusted files: errors of libraries become FileError, and text is quoted safely."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from firstcontact.core import FileError, InputError

#: Longest quoted value and library message, in characters, and longest list, in names.
_QUOTED = 60
_REASON = 200
_LISTED = 10


@contextmanager
def library_errors(origin: object, kind: str, remedy: str) -> Iterator[None]:
    """Convert any error of a library that reads a file to FileError. Hide the library's warnings.

    The message says that ``origin`` cannot be read as ``kind``, and ends with ``remedy``.
    """
    try:
        with warnings.catch_warnings(action="ignore"):
            yield
    except InputError:
        raise
    except Exception as error:  # damage can cause any error in a library
        text = " ".join(str(error).split()).rstrip(".") or type(error).__name__
        text = text if text.isprintable() else ascii(text)[1:-1]
        reason = text if len(text) <= _REASON else f"{text[:_REASON]}..."
        raise FileError(f"{origin} cannot be read as {kind} ({reason}): {remedy}") from error


def as_text(value: Any) -> str:
    """Convert a value to text that UTF-8 can encode. Invalid bytes are replaced."""
    text = value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    return text.encode("utf-8", "replace").decode()


def quote(value: Any) -> str:
    """Return a value for a message: on one line, cut if long, and in quotes if it is a text."""
    text = as_text(value)
    if isinstance(value, str | bytes):
        text = repr(text) if text.isprintable() else ascii(text)
    return text if len(text) <= _QUOTED else f"{text[:_QUOTED]}..."


def listed(names: Sequence[str]) -> str:
    """Return the first 10 names as a text, with the number of the others: "a, b and 3 more"."""
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return ", ".join(quote(n).strip("'") for n in names[:_LISTED]) + more


def one_of(origin: object, name: str, value: Any, choices: Collection[str]) -> str:
    """Return a value as text. Raise FileError unless it is one of ``choices``.

    The message names the file ``origin`` and the field ``name``.
    """
    text = as_text(value)
    if text not in choices:
        raise FileError(
            f"{origin}: '{name}' is {quote(text)} and must be one of {', '.join(choices)}"
        )
    return text
