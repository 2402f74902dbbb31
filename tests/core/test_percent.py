"""Shares as percentages."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import percent


@pytest.mark.parametrize(
    ("share", "decimals", "said"),
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
def test_a_share_has_the_decimals_that_are_of_use(share: float, decimals: int, said: str) -> None:
    assert percent(share, decimals) == said


@given(st.floats(0, 1, exclude_max=True), st.integers(0, 2))
def test_no_share_is_rounded_up_to_all(share: float, decimals: int) -> None:
    said = percent(share, decimals)
    assert float(said.removesuffix(" %")) < 100
    assert len(said) <= len("99.99 %")
