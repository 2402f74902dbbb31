"""Scores of the study against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from firstcontact.models import per_object
from firstcontact_lab.study.scores import RankCorrelation, over_objects, rank_correlation


def test_each_object_counts_once_whatever_its_pinches() -> None:
    truth = np.array([10.0, 10.0, 10.0, 40.0])
    names = np.array(["a", "a", "a", "b"])
    means = over_objects(per_object(truth, np.array([11.0, 13.0, 12.0, 44.0]), names, names))
    assert means.rmse == pytest.approx(np.sqrt((2**2 + 4**2) / 2))
    assert means.n == 2


def test_permutation_p_is_exact_for_few() -> None:
    """Two of the 24 orders of four values correlate as strongly, one with the opposite sign."""
    computed = rank_correlation(np.arange(4.0), np.array([1.0, 3.0, 7.0, 9.0]), 0)
    assert computed.rho == pytest.approx(1.0)
    assert computed.p == pytest.approx(2 / 24)
    assert computed.exact
    assert rank_correlation(np.array([1.0, 1.0, 1.0]), np.arange(3.0), 0) == RankCorrelation(n=3)
