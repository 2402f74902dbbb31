"""Only declared groups may be on both sides of a split."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from sklearn.model_selection import GroupKFold, StratifiedGroupKFold, StratifiedKFold

from firstcontact.models.splits import Group, Split, by_session, inner_folds, leave_one_out


@st.composite
def pinches(draw: st.DrawFn):
    """Return sessions, specimens and levels of pinches, each level often enough for a split."""
    n = draw(st.integers(12, 60))
    sessions = np.array(draw(st.lists(st.sampled_from("abcdef"), min_size=n, max_size=n)))
    levels = np.array(draw(st.lists(st.sampled_from([10.0, 20.0, 29.0]), min_size=n, max_size=n)))
    counts = np.unique(levels, return_counts=True)[1]
    assume(len(counts) >= 2 and counts.min() >= 2)
    specimens = np.array([f"block {level:g}" for level in levels])
    return sessions, specimens, levels


def covered(splits: list[Split]) -> list[int]:
    return sorted(np.concatenate([s.test for s in splits]).tolist())


@given(pinches(), st.integers(0, 5))
def test_by_session_holds_whole_sessions_out_and_asks_about_everyone_once(made, seed: int) -> None:
    sessions, specimens, levels = made
    assume(len(set(sessions)) >= 2)
    splits = by_session(sessions, levels, seed)
    assert covered(splits) == list(range(len(levels)))
    for split in splits:
        split.check(sessions, specimens)
        assert Group.SESSION not in split.shares
        assert not set(sessions[split.train]) & set(sessions[split.test])


@given(pinches(), st.integers(0, 2**32 - 1), st.integers(2, 6))
def test_folds_are_those_of_scikit_learn(made, seed: int, k: int) -> None:
    sessions, _, levels = made
    assume(len(set(sessions)) >= 2)
    strata = np.unique(levels, return_inverse=True)[1]
    rarest, folds = np.bincount(strata).min(), min(k, len(set(sessions)))
    grouped = StratifiedGroupKFold(folds, shuffle=True, random_state=seed)
    splitter = grouped if rarest >= folds else GroupKFold(folds)
    expected = [(s.train, s.test) for s in by_session(sessions, levels, seed, k)]
    check_folds(expected, splitter.split(levels[:, None], strata, sessions))
    even = strata * 0
    check_folds(
        inner_folds(levels, sessions, seed, k),
        grouped.split(levels[:, None], strata if rarest >= folds else even, sessions),
    )
    alone = StratifiedKFold(k, shuffle=True, random_state=seed)
    check_folds(
        inner_folds(levels, None, seed, k),
        alone.split(levels[:, None], strata if rarest >= k else even),
    )


def check_folds(folds, expected) -> None:
    """Compare folds with those of scikit-learn, which yields empty ones as well."""
    expected = [(train, test) for train, test in expected if len(test)]
    assert [(a.tolist(), b.tolist()) for a, b in folds] == [
        (a.tolist(), b.tolist()) for a, b in expected
    ]


@given(pinches())
def test_a_level_left_out_is_on_one_side_only(made) -> None:
    sessions, specimens, levels = made
    splits = leave_one_out(levels)
    assert len(splits) == len(np.unique(levels))
    assert covered(splits) == list(range(len(levels)))
    for split in splits:
        split.check(sessions, specimens)
        assert not set(levels[split.train]) & set(levels[split.test])


@given(pinches(), st.integers(0, 1000))
def test_a_pinch_moved_across_is_noticed(made, pick: int) -> None:
    sessions, specimens, levels = made
    assume(len(set(sessions)) >= 2)
    split = by_session(sessions, levels, 0)[0]
    moved = split.test[pick % len(split.test)]
    with pytest.raises(ValueError, match="a pinch on both sides"):
        Split("mixed", np.append(split.train, moved), split.test, split.shares).check(
            sessions, specimens
        )
    if len(split.test) > 1 and (sessions[split.test] == sessions[moved]).sum() > 1:
        remainder = split.test[split.test != moved]
        with pytest.raises(ValueError, match="session"):
            Split("mixed", np.append(split.train, moved), remainder, split.shares).check(
                sessions, specimens
            )


def test_specimens_on_both_sides_must_be_declared() -> None:
    names = np.array(["a", "a"])
    split = Split("x", np.array([0]), np.array([1]), frozenset({Group.SESSION}))
    with pytest.raises(ValueError, match="the specimen 'a' on both sides"):
        split.check(np.array(["s", "s"]), names)


def test_unknown_sessions_cannot_be_told_apart() -> None:
    with pytest.raises(ValueError, match="two known sessions"):
        by_session(np.array(["a", ""]), np.array([1.0, 2.0]), 0)
    split = Split("x", np.array([0]), np.array([1]))
    with pytest.raises(ValueError, match="session"):
        split.check(np.array(["", ""]), np.array(["a", "b"]))


def test_an_empty_side_is_refused() -> None:
    with pytest.raises(ValueError, match="empty side"):
        Split("x", np.array([], dtype=int), np.array([1])).check(np.array([""]), np.array([""]))
