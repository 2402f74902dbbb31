"""Intervals: their bounds, and their coverage."""

import json
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.models import Task, load_model, make_estimator
from firstcontact.models.card import TrainingRecord
from firstcontact.models.interval import (
    RANGE_PINCHES,
    Interval,
    conformal_interval,
    held_out_coverage,
    missing_interval_reason,
)
from firstcontact.models.predictions import SHARED, combine
from firstcontact.testing.synthetic import RATE, toy_windows
from saved import save_window

STEPPED = Interval(0.9, (20.0, 40.0), (1.0, 3.0, 8.0))


@given(st.floats(-1e6, 1e6))
def test_bounds_lie_on_the_scale_and_around_the_answer(value: float) -> None:
    low, high = STEPPED.around(value)
    assert 0.0 <= low <= high <= 100.0
    if 0.0 <= value <= 100.0:
        assert low <= value <= high


def test_width_follows_the_answer() -> None:
    assert STEPPED.around(10.0) == (9.0, 11.0)
    assert STEPPED.around(20.0) == (17.0, 23.0)  # an edge belongs to the range above
    assert STEPPED.around(39.9) == pytest.approx((36.9, 42.9))
    assert STEPPED.around(96.0) == (88.0, 100.0)
    assert replace(STEPPED, limits=None).around(96.0) == (88.0, 104.0)


@pytest.mark.parametrize(
    "changes",
    [
        {"level": 0.0},
        {"level": 1.0},
        {"edges": (20.0,)},
        {"edges": (40.0, 20.0)},
        {"half_widths": (1.0, -1.0, 1.0)},
        {"half_widths": (1.0, float("nan"), 1.0)},
        {"limits": (100.0, 0.0)},
    ],
    ids=str,
)
def test_numbers_that_do_not_fit(changes: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="do not fit"):
        replace(STEPPED, **changes)


@given(
    st.integers(RANGE_PINCHES, 300),
    st.integers(10, 19).map(lambda k: k / 20),
    st.integers(0, 2**32 - 1),
)
def test_it_is_the_conformal_quantile_of_each_range(n: int, level: float, seed: int) -> None:
    """Closed form: the ceil((n + 1) level)-th smallest of the n residuals in a range."""
    rng = np.random.default_rng(seed)
    answers = rng.uniform(0, 100, n)
    truth = answers + rng.normal(0, 0.1 + answers / 10)
    if missing_interval_reason(answers, rng.permuted(np.arange(n) % 3).astype(str), level):
        return
    interval = conformal_interval(answers, truth, level, limits=None)
    member = np.searchsorted(interval.edges, answers, side="right")
    for number, half in enumerate(interval.half_widths):
        residuals = np.sort(np.abs(truth - answers)[member == number])
        assert len(residuals) >= RANGE_PINCHES
        place = -(-(len(residuals) + 1) * round(20 * level) // 20)
        # Where the product is whole, rounding may take the next one, which is wider.
        right = residuals[place - 1 : place + 1]
        assert half == pytest.approx(right[np.abs(right - half).argmin()], abs=1e-6)


@pytest.mark.parametrize("level", [0.5, 0.8, 0.9, 0.95])
def test_new_truths_are_held_as_often_as_the_level_says(level: float) -> None:
    """The mean coverage over many intervals must be the level or slightly more."""
    rng = np.random.default_rng(1)
    held_out = []
    for _ in range(40):
        answers = rng.uniform(0, 60, (2, 200))
        truth = answers + rng.normal(0, 1 + answers / 20)
        interval = conformal_interval(answers[0], truth[0], level)
        low, high = interval.around_all(answers[1])
        held_out.append(np.mean((low <= truth[1]) & (truth[1] <= high)))
    assert level - 0.02 < np.mean(held_out) < level + 0.04


def test_answers_that_are_all_alike_make_one_range() -> None:
    answers = np.full(200, 29.0)
    interval = conformal_interval(answers, answers + np.linspace(-5, 5, 200))
    assert all(h == pytest.approx(4.5, abs=0.1) for h in interval.half_widths)
    low, high = interval.around(29.0)
    assert high - low == pytest.approx(9.0, abs=0.2)


def test_a_fold_is_asked_with_what_the_others_taught() -> None:
    """One fold of three has huge residuals. Only its own bounds must be too narrow."""
    rng = np.random.default_rng(2)
    answers = rng.uniform(2, 50, 300)
    folds = np.arange(300) % 3
    truth = answers + np.where(folds == 0, 40.0, rng.uniform(-1, 1, 300))
    checked = held_out_coverage(answers, truth, folds)
    assert checked["n"] == 300
    assert checked["coverage"] == pytest.approx(2 / 3)


@pytest.mark.parametrize(
    ("n", "names", "words"),
    [
        (200, ["a", "b"], "2 known sessions"),
        (200, ["a", "b", ""], "2 known sessions"),
        (30, ["a", "b", "c"], "30 pinches"),
        (200, ["a", "b", "c"], ""),
    ],
)
def test_too_little_for_an_interval(n: int, names: list[str], words: str) -> None:
    sessions = np.array([names[i % len(names)] for i in range(n)])
    text = missing_interval_reason(np.zeros(n), sessions, 0.9)
    assert text.startswith(words)
    assert bool(text) == bool(words)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    model = make_estimator("peak", Task.REGRESSION, RATE).fit(*toy_windows(60))
    record = TrainingRecord(calibration={"pinches": 60})
    return save_window(model, tmp_path / "m", interval=STEPPED, record=record)


def test_the_card_carries_it(folder: Path) -> None:
    assert load_model(folder).windows[0].interval == STEPPED
    assert load_model(folder / "model.json").windows[0].interval == STEPPED


def test_an_interval_on_a_spread_is_wide_where_the_spread_is_and_holds_its_level() -> None:
    rng = np.random.default_rng(2)
    spreads = np.exp(rng.normal(0, 0.7, 4000))
    answers = rng.uniform(20, 80, 4000)
    truth = answers + spreads * rng.normal(0, 3.0, 4000)
    first, remainder = np.arange(4000) < 2000, np.arange(4000) >= 2000
    scaled = conformal_interval(answers[first], truth[first], 0.9, None, spreads[first])
    plain = conformal_interval(answers[first], truth[first], 0.9, None)
    assert scaled.scaled
    assert not plain.scaled
    ends = scaled.around_all(answers[remainder], spreads[remainder])
    is_covered = (ends[0] <= truth[remainder]) & (truth[remainder] <= ends[1])
    assert is_covered.mean() == pytest.approx(0.9, abs=0.02)
    plain_ends = plain.around_all(answers[remainder])
    assert np.mean(ends[1] - ends[0]) < np.mean(plain_ends[1] - plain_ends[0])
    low, high = scaled.around(50.0, 2.0)
    narrow = scaled.around(50.0, 1.0)
    assert high - low == pytest.approx(2 * (narrow[1] - narrow[0]))
    again = msgspec.convert(json.loads(json.dumps(asdict(scaled))), Interval)
    assert again == scaled


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
