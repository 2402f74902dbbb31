"""Splits of pinches into training and test.

Each split declares whether a session or a specimen may have pinches on both sides.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

Index = NDArray[np.intp]
#: Largest number of folds of a split by session.
FOLDS = 5


class Group(StrEnum):
    """Kind of group that pinches belong to: a session or a specimen (one physical object)."""

    SESSION = "session"
    SPECIMEN = "specimen"


@dataclass(frozen=True, slots=True, eq=False)
class Split:
    """Positions of the training pinches and of the test pinches of one split."""

    #: Name of the held-out fold, level or specimen, unique within a list of splits.
    name: str
    train: Index
    test: Index
    #: Kinds whose groups may be in both training and test.
    shares: frozenset[Group] = field(default_factory=frozenset)

    def check(self, sessions: NDArray[np.str_], specimens: NDArray[np.str_]) -> None:
        """Raise ValueError if a side is empty, or a pinch is on both sides.

        Raise it also if a session or specimen is on both sides, unless ``shares`` allows that.
        """
        if not len(self.train) or not len(self.test):
            raise ValueError(f"split {self.name!r} has an empty side: give both sides pinches")
        if len(np.intersect1d(self.train, self.test)):
            raise ValueError(
                f"split {self.name!r} has a pinch on both sides: remove it from one of them"
            )
        for group, names in ((Group.SESSION, sessions), (Group.SPECIMEN, specimens)):
            both = set(names[self.train]) & set(names[self.test])
            if both and group not in self.shares:
                raise ValueError(
                    f"split {self.name!r} has the {group} {str(min(both))!r} on both sides, which "
                    "the field 'shares' does not declare: declare it, or keep it on one side"
                )


def by_session(
    sessions: NDArray[np.str_], classes: NDArray[Any], seed: int, folds: int = FOLDS
) -> list[Split]:
    """Return splits that hold out whole sessions. Each class is spread evenly over the folds.

    Raise ValueError with fewer than two sessions, or if one has no name.
    """
    names = np.unique(sessions)
    if len(names) < 2 or "" in names:
        raise ValueError(
            "a split by session needs pinches of two known sessions or more: give each pinch its "
            "session"
        )
    folds = min(folds, len(names))
    # Small classes cannot be stratified; sessions stay whole either way.
    is_rare = np.unique(classes, return_counts=True)[1].min() < folds
    numbers = (
        _even_folds(sessions, folds)
        if is_rare
        else _stratified_group_folds(classes, sessions, folds, seed)
    )
    return [
        Split(f"sessions {fold}", train, test, frozenset({Group.SPECIMEN}))
        for fold, (train, test) in enumerate(_fold_positions(numbers, folds))
        if len(train) and len(test)
    ]


def leave_one_out(values: NDArray[Any], shares: Sequence[Group] = (Group.SESSION,)) -> list[Split]:
    """Return one split per distinct value, such as a Shore A, which holds out all its pinches.

    ``values`` holds the value of each pinch. ``shares`` are the kinds of groups that may be on both
    sides.
    """
    everyone, kinds = np.arange(len(values)), frozenset(shares)
    return [
        Split(f"without {value}", everyone[values != value], everyone[values == value], kinds)
        for value in np.unique(values)
        if (values != value).any()
    ]


#: Number of different target values above which they are grouped into this many ranges.
RANGES = 5


def inner_folds(
    y: NDArray[Any], groups: NDArray[Any] | None, seed: int, k: int = 3
) -> Iterator[tuple[Index, Index]]:
    """Yield positions to fit to and positions to hold out, for at most ``k`` folds.

    Whole groups (sessions) are held out, or single pinches without ``groups``. Each fold has
    similar targets. No fold is yielded if there are too few pinches.
    """
    if groups is not None and len(np.unique(groups)) < 2:
        groups = None
    k = min(k, len(y) if groups is None else len(np.unique(groups)))
    if k < 2:
        return
    strata = _strata(y, k)
    numbers = (
        _stratified_folds(strata, k, seed)
        if groups is None
        else _stratified_group_folds(strata, groups, k, seed)
    )
    yield from (fold for fold in _fold_positions(numbers, k) if len(fold[1]))


def _strata(y: NDArray[Any], k: int) -> Index:
    """Return a number for each target, equal within a class, to balance the folds by class.

    Many different targets are first divided into ranges. All numbers are 0 if a class has fewer
    than ``k`` targets.
    """
    values, numbers = np.unique(y, return_inverse=True)
    if len(values) > RANGES:
        edges = np.quantile(y, np.arange(1, RANGES) / RANGES)
        numbers = np.unique(np.searchsorted(edges, y, side="right"), return_inverse=True)[1]
    rare = np.bincount(numbers).min() < k
    return np.zeros(len(y), dtype=np.intp) if rare else numbers


def _fold_positions(numbers: Index, k: int) -> Iterator[tuple[Index, Index]]:
    """Yield a pair of index arrays per fold: pinches outside of the fold, and inside.

    ``numbers`` holds the fold of each pinch, from 0 to ``k`` - 1.
    """
    for fold in range(k):
        yield np.flatnonzero(numbers != fold), np.flatnonzero(numbers == fold)


# The three functions below give the folds of scikit-learn 1.9, which the base install lacks.


def _even_folds(groups: NDArray[Any], k: int) -> Index:
    """Return a fold number for each pinch, as scikit-learn's ``GroupKFold`` does."""
    _, group, sizes = np.unique(groups, return_inverse=True, return_counts=True)
    pinches, fold = np.zeros(k), np.empty(len(sizes), np.intp)
    for number in np.argsort(sizes, kind="stable")[::-1]:
        fold[number] = pinches.argmin()
        pinches[fold[number]] += sizes[number]
    return fold[group]


def _stratified_folds(strata: NDArray[Any], k: int, seed: int) -> Index:
    """Return a fold number for each pinch, as scikit-learn's shuffled ``StratifiedKFold`` does."""
    rng = np.random.RandomState(seed)
    _, first, number = np.unique(strata, return_index=True, return_inverse=True)
    appearance = np.argsort(np.argsort(first))[number]
    ordered, out = np.sort(appearance), np.empty(len(strata), np.intp)
    for stratum in range(len(first)):
        folds = np.sort(np.flatnonzero(ordered == stratum) % k)
        rng.shuffle(folds)
        out[appearance == stratum] = folds
    return out


def _stratified_group_folds(strata: NDArray[Any], groups: NDArray[Any], k: int, seed: int) -> Index:
    """Return a fold number for each pinch, as scikit-learn's ``StratifiedGroupKFold`` does."""
    _, stratum, sizes = np.unique(strata, return_inverse=True, return_counts=True)
    group = np.unique(groups, return_inverse=True)[1]
    counts = np.zeros((group.max() + 1, len(sizes)))
    np.add.at(counts, (group, stratum), 1)
    order = np.random.RandomState(seed).permutation(len(counts))
    in_fold, fold = np.zeros((k, len(sizes))), np.empty(len(counts), np.intp)
    for number in order[np.argsort(-counts[order].std(axis=1), kind="stable")]:
        best, least, fewest = 0, np.inf, np.inf
        for candidate in range(k):
            trial = in_fold.copy()
            trial[candidate] += counts[number]
            unevenness = (trial / sizes).std(axis=0).mean()
            pinches = in_fold[candidate].sum()
            if unevenness < least or (np.isclose(unevenness, least) and pinches < fewest):
                best, least, fewest = candidate, unevenness, pinches
        in_fold[best] += counts[number]
        fold[number] = best
    return fold[group]
