"""Splits of the study declare the groups that both sides share."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.models import Group
from firstcontact_lab.study.splits import random_90_10, random_folds, unseen_objects


@given(st.integers(2, 9), st.integers(0, 5))
def test_random_splits_say_what_they_share(each: int, seed: int) -> None:
    levels = np.repeat([10.0, 20.0, 29.0], each)
    folds = random_folds(levels, seed)
    for split in (*random_90_10(np.repeat(levels, 10), seed), *folds):
        assert split.shares == {Group.SESSION, Group.SPECIMEN}
        assert not set(split.train) & set(split.test)
    assert sorted(np.concatenate([s.test for s in folds]).tolist()) == list(range(len(levels)))


@given(st.integers(2, 9), st.integers(0, 5))
def test_random_splits_do_not_depend_on_whether_levels_are_whole_numbers(
    each: int, seed: int
) -> None:
    levels = np.repeat([10.0, 20.0, 29.0], each)
    for split in (random_folds, lambda y, seed: random_90_10(np.repeat(y, 10), seed)):
        whole, fractional = (split(y, seed) for y in (levels, levels - 0.5))
        assert [s.test.tolist() for s in whole] == [s.test.tolist() for s in fractional]


def test_roles_decide_who_is_unseen() -> None:
    split = unseen_objects(np.array([False, True, False]))
    assert split.train.tolist() == [0, 2]
    assert split.test.tolist() == [1]
    assert not split.shares


def test_the_same_seed_gives_the_same_split() -> None:
    levels = np.repeat([1.0, 2.0, 3.0], 30)
    first, second = random_90_10(levels, 7)[0], random_90_10(levels, 7)[0]
    assert first.test.tolist() == second.test.tolist()
    assert first.test.tolist() != random_90_10(levels, 8)[0].test.tolist()
    assert len(first.test) == 9
    assert np.unique(levels[first.test], return_counts=True)[1].tolist() == [3, 3, 3]
