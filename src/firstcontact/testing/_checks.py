"""Assertion that several conformance checks use."""

from __future__ import annotations

from collections.abc import Callable

from firstcontact.core import InputError


def refused(words: str, call: Callable[[], object]) -> None:
    """Assert that a call raises an InputError that contains these words."""
    message = None
    try:
        call()
    except InputError as error:
        message = str(error)
    assert message is not None, f"not refused; expected an InputError with {words!r}"
    assert words in message, f"refused, but without {words!r}: {message}"
