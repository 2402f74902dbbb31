"""Pooled estimate from several pinches of one object: weights, and smallest interval."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.models.predictions import SHARED, combine

halves = st.lists(st.floats(0.5, 40.0), min_size=1, max_size=20)


@given(value=st.floats(0, 100), half=st.floats(0.5, 40))
def test_one_pinch_is_itself(value: float, half: float) -> None:
    one = combine([value], [half])
    assert one.value == pytest.approx(value)
    assert one.half_width == pytest.approx(half)
    assert one.pinches == 1
    assert 0 <= one.low <= one.high <= 100


@given(widths=halves)
def test_the_interval_keeps_what_all_pinches_share(widths: list[float]) -> None:
    estimate = combine([50.0] * len(widths), widths)
    assert estimate.value == pytest.approx(50.0)
    assert min(widths) * SHARED <= estimate.half_width * (1 + 1e-12)
    assert estimate.half_width <= max(widths) * (1 + 1e-12)


def test_more_pinches_are_surer_down_to_the_shared_part() -> None:
    estimate = [combine([30.0] * n, [10.0] * n).half_width for n in (1, 2, 3, 10, 10_000)]
    assert estimate == sorted(estimate, reverse=True)
    assert estimate[-1] == pytest.approx(10 * SHARED, rel=1e-3)
    assert estimate[2] == pytest.approx(10 * np.sqrt(SHARED**2 + (1 - SHARED**2) / 3))


def test_a_sure_pinch_counts_more() -> None:
    # Weights 1 and 1/4.
    assert combine([20.0, 40.0], [5.0, 10.0]).value == pytest.approx(24.0)
