"""What the checks share."""

from __future__ import annotations

from collections.abc import Callable

from firstcontact.core import InputError


def refused(words: str, call: Callable[[], object]) -> None:
    """Assert that a call is refused with an InputError that holds these words."""
    said = None
    try:
        call()
    except InputError as error:
        said = str(error)
    assert said is not None, f"not refused; expected an InputError with {words!r}"
    assert words in said, f"refused, but without {words!r}: {said}"
