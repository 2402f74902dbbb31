"""Shares as percentages."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import percent


@pytest.mark.parametrize(
    ("share", "decimals", "expected"),
    [
        (1.0, 1, "100.0 %"),
        (0.972, 1, "97.2 %"),
        (0.99966, 1, "99.97 %"),
        (0.99999, 1, "99.99 %"),
        (0.996, 0, "99.6 %"),
        (0.4, 0, "40 %"),
        (1.2, 0, "120 %"),
    ],
)
def test_percent_has_useful_decimals(share: float, decimals: int, expected: str) -> None:
    assert percent(share, decimals) == expected


@given(st.floats(0, 1, exclude_max=True), st.integers(0, 2))
def test_percent_is_never_rounded_up_to_100(share: float, decimals: int) -> None:
    text = percent(share, decimals)
    assert float(text.removesuffix(" %")) < 100
    assert len(text) <= len("99.99 %")
