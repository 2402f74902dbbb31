"""Scores and splits of the study against closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.models.scores import per_object
from firstcontact.models.splits import Group
from firstcontact_lab.study.scores import (
    RankCorrelation,
    over_objects,
    random_90_10,
    random_folds,
    rank_correlation,
)


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


@given(st.integers(2, 9), st.integers(0, 5))
def test_random_splits_say_what_they_share(each: int, seed: int) -> None:
    levels = np.repeat([9.5, 20.0, 28.5], each)  # scikit-learn stratifies whole numbers only
    folds = random_folds(levels, seed)
    for split in (*random_90_10(np.repeat(levels, 10), seed), *folds):
        assert split.shares == {Group.SESSION, Group.SPECIMEN}
        assert not set(split.train) & set(split.test)
    assert sorted(np.concatenate([s.test for s in folds]).tolist()) == list(range(len(levels)))
