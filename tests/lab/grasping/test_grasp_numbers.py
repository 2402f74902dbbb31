"""Means and shares of rows with known numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from toy_rows import OBJECTS, PEAKS, SESSIONS, row, rows

from firstcontact_lab.grasping._numbers import by_policy, summary
from firstcontact_lab.grasping.settings import HEADLINE

FORCES = st.lists(st.floats(0.1, 20.0), min_size=6, max_size=6)


@given(FORCES)
def test_means_are_means_and_lie_in_their_intervals(peaks: list[float]) -> None:
    rows = [row("block 5", s, "none", HEADLINE, p) for s, p in enumerate(peaks)]
    computed = summary(rows, 0)
    assert computed.peak_n == pytest.approx(np.mean(peaks))
    assert computed.squeeze_mm == pytest.approx(np.mean(peaks))
    low, high = computed.intervals["peak_n"]
    assert low - 1e-9 <= computed.peak_n <= high + 1e-9


def test_the_time_is_of_steady_grasps_only() -> None:
    rows = [row("block 5", s, "none", HEADLINE, 1.0) for s in range(4)]
    rows[3] = replace(rows[3], time=None)
    computed = summary(rows, 0)
    assert computed.time_ms == pytest.approx(110.0)
    assert computed.steady == 0.75
    never = summary([replace(r, time=None) for r in rows], 0)
    assert never.time_ms is None
    assert never.steady == 0.0


def test_the_trees_have_every_variant_and_latency() -> None:
    policies = by_policy(rows(), 0)
    assert list(policies) == list(PEAKS)
    for variant, at in policies.items():
        assert list(at) == ["20", "60"]
        assert at["20"]["all"].n == SESSIONS * len(OBJECTS)
        assert at["20"]["soft"].n == SESSIONS * 2
        assert at["20"]["soft"].peak_n == pytest.approx(PEAKS[variant])
        assert at["60"]["brittle"].broken == (PEAKS[variant] > 6)
