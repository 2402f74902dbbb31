"""A stranger's words in our sentences: on one line, without control characters, not too many."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

#: How much of a value is shown, and of what a library says, characters; and of a list, names.
_SHOWN = 60
_REASON = 200
_LISTED = 10


def text_of(value: Any) -> str:
    """A value as text; bytes are UTF-8, and what is none of it is replaced."""
    text = value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    # Half a character, as NumPy and HDF5 can hold it, is none in UTF-8.
    return text.encode("utf-8", "replace").decode()


def quote(value: Any) -> str:
    """A value as messages show it: quoted where it is text."""
    text = text_of(value)
    if isinstance(value, str | bytes):
        text = repr(text) if text.isprintable() else ascii(text)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def listed(names: Sequence[str]) -> str:
    """Some of the names, and how many more there are."""
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return ", ".join(quote(n).strip("'") for n in names[:_LISTED]) + more


def reason(error: BaseException) -> str:
    """What a library says of a stranger's file."""
    text = " ".join(str(error).split()) or type(error).__name__
    text = text if text.isprintable() else ascii(text)[1:-1]
    return text if len(text) <= _REASON else f"{text[:_REASON]}..."
