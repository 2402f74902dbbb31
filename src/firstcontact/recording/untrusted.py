"""Protection against files of others: errors of reading libraries, and quoting of text."""

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
    """Turn any error of a library that reads a file into one FileError, and hide warnings."""
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
    """Return a value as text that UTF-8 can encode. Invalid bytes are replaced."""
    text = value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    return text.encode("utf-8", "replace").decode()


def quote(value: Any) -> str:
    """Return a value for a message: on one line, not too long, and text in quotes."""
    text = as_text(value)
    if isinstance(value, str | bytes):
        text = repr(text) if text.isprintable() else ascii(text)
    return text if len(text) <= _QUOTED else f"{text[:_QUOTED]}..."


def listed(names: Sequence[str]) -> str:
    """Return the first names as text, with the number of the others."""
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return ", ".join(quote(n).strip("'") for n in names[:_LISTED]) + more


def one_of(origin: object, name: str, value: Any, choices: Collection[str]) -> str:
    """Return a value as text. Raise FileError unless it is one of the choices."""
    text = as_text(value)
    if text not in choices:
        raise FileError(
            f"{origin}: '{name}' is {quote(text)} and must be one of {', '.join(choices)}"
        )
    return text
