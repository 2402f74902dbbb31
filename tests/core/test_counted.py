"""Numbers with singular and plural nouns."""

from __future__ import annotations

import pytest

from firstcontact.core import counted


@pytest.mark.parametrize(
    ("number", "noun", "expected"),
    [
        (1, "pinch", "1 pinch"),
        (0, "pinch", "0 pinches"),
        (2, "stretch", "2 stretches"),
        (2, "epoch", "2 epochs"),
        (1200, "WAV file", "1,200 WAV files"),
        (2, "policy", "2 policies"),
        (2, "day", "2 days"),
        (3, "Shore A level", "3 Shore A levels"),
    ],
)
def test_one_is_singular(number: int, noun: str, expected: str) -> None:
    assert counted(number, noun) == expected
