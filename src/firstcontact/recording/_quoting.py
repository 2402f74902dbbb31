"""Quotation of text from files in messages: one line, no control characters, bounded length."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

#: Longest quoted value and library message, in characters, and longest list, in names.
_SHOWN = 60
_REASON = 200
_LISTED = 10


def as_text(value: Any) -> str:
    """Return a value as text. Bytes are decoded as UTF-8; invalid ones are replaced."""
    text = value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    # NumPy and HDF5 can hold surrogates, which UTF-8 cannot encode.
    return text.encode("utf-8", "replace").decode()


def quote(value: Any) -> str:
    """Return a value for a message. Text is quoted."""
    text = as_text(value)
    if isinstance(value, str | bytes):
        text = repr(text) if text.isprintable() else ascii(text)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def listed(names: Sequence[str]) -> str:
    """Return the first names as text, and the number of further ones."""
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return ", ".join(quote(n).strip("'") for n in names[:_LISTED]) + more


def reason(error: BaseException) -> str:
    """Return a library's error message about a file, shortened."""
    text = " ".join(str(error).split()) or type(error).__name__
    text = text if text.isprintable() else ascii(text)[1:-1]
    return text if len(text) <= _REASON else f"{text[:_REASON]}..."
