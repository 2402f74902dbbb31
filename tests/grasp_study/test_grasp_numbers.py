"""Means, shares and paired differences, on rows whose numbers are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from toy_rows import OBJECTS, PEAKS, SESSIONS, row, rows

from firstcontact.grasp_study._numbers import (
    by_object,
    by_policy,
    compared,
    headline,
    summary,
)
from firstcontact.grasp_study.results import Met
from firstcontact.grasp_study.settings import HEADLINE

FORCES = st.lists(st.floats(0.1, 20.0), min_size=6, max_size=6)


@given(FORCES)
def test_means_are_means_and_lie_in_their_intervals(peaks: list[float]) -> None:
    its = [row("block 5", s, "none", HEADLINE, p) for s, p in enumerate(peaks)]
    found = summary(its, 0)
    assert found.peak_n == pytest.approx(np.mean(peaks))
    assert found.squeeze_mm == pytest.approx(np.mean(peaks))
    low, high = found.intervals["peak_n"]
    assert low - 1e-9 <= found.peak_n <= high + 1e-9


def test_the_time_is_of_steady_grasps_only() -> None:
    its = [row("block 5", s, "none", HEADLINE, 1.0) for s in range(4)]
    its[3] = replace(its[3], time=None)
    found = summary(its, 0)
    assert found.time_ms == pytest.approx(110.0)
    assert found.steady == 0.75
    never = summary([replace(r, time=None) for r in its], 0)
    assert never.time_ms is None
    assert never.steady == 0.0


@given(FORCES, st.floats(0.2, 3.0))
def test_a_difference_that_is_the_same_everywhere_has_no_width(
    peaks: list[float], ratio: float
) -> None:
    theirs = [row("block 5", s, "none", HEADLINE, p) for s, p in enumerate(peaks)]
    ours = [replace(r, peak=ratio * r.peak, time=2 * (r.time or 0.0)) for r in theirs]
    found = compared(ours, theirs, 0)
    assert found.less_peak == pytest.approx(1 - ratio)
    assert found.intervals["less_peak"] == pytest.approx([1 - ratio] * 2)
    assert found.longer == pytest.approx(1.0)


def test_only_the_same_pinches_are_compared() -> None:
    one, other = (row("block 5", s, "none", HEADLINE, 1.0) for s in (0, 1))
    with pytest.raises(ValueError, match="different pinches"):
        compared([one], [other], 0)


def test_times_are_compared_where_both_held() -> None:
    theirs = [row("block 5", s, "none", HEADLINE, 1.0) for s in range(3)]
    ours = [replace(theirs[0], time=0.2), replace(theirs[1], time=None), theirs[2]]
    found = compared(ours, [*theirs[:2], replace(theirs[2], time=None)], 0)
    assert found.longer == pytest.approx(1.0)
    assert compared([replace(r, time=None) for r in ours], theirs, 0).longer is None


def test_the_trees_have_every_variant_latency_and_object() -> None:
    policies, objects = by_policy(rows(), 0), by_object(rows(), 0)
    assert list(policies) == list(PEAKS)
    for variant, at in policies.items():
        assert list(at) == ["20", "60"]
        assert at["20"]["all"].n == SESSIONS * len(OBJECTS)
        assert at["20"]["soft"].n == SESSIONS * 2
        assert at["20"]["soft"].peak_n == pytest.approx(PEAKS[variant])
        assert at["60"]["brittle"].broken == (PEAKS[variant] > 6)
    assert list(objects) == list(OBJECTS)
    assert [o.breaks for o in objects.values()] == [False, False, False, True]


def test_the_headline_judges_what_the_rows_say() -> None:
    found = headline(rows(), 0)
    assert found.about.best_feedback == "feedback_fast"
    against = found["first_contact"]["feedback_fast"]
    assert against.soft.less_peak == pytest.approx(1 - 2.6 / 4.0)
    assert against.met.all
    slower = [
        replace(r, time=1.2 * r.time, dropped=True)
        if r.variant == "first_contact" and r.time
        else r
        for r in rows()
    ]
    met = headline(slower, 0)["first_contact"]["feedback"].met
    assert met == Met(less_peak=True, more_dropped=False, longer=False)
    weaker = [replace(r, peak=4.9) if r.variant == "first_contact" else r for r in rows()]
    met = headline(weaker, 0)["first_contact"]["feedback"].met
    assert met == Met(less_peak=False, more_dropped=True, longer=True)
