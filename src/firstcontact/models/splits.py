"""Splits of pinches into training and test.

Each split declares if a session or a specimen may have pinches on both sides.
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
    """Kind of group of pinches. A split may allow a kind to be in both training and test."""

    SESSION = "session"
    SPECIMEN = "specimen"


@dataclass(frozen=True, slots=True, eq=False)
class Split:
    """Split: positions of the training pinches and of the test pinches.

    Parameters
    ----------
    name
        Name of the held-out fold, level or specimen, unique within a list of splits.
    train, test
        Positions, each shape (n,).
    shares
        Kinds whose groups may be in both training and test. :meth:`check` refuses a shared group
        of any other kind.
    """

    name: str
    train: Index
    test: Index
    shares: frozenset[Group] = field(default_factory=frozenset)

    def check(self, sessions: NDArray[np.str_], specimens: NDArray[np.str_]) -> None:
        """Refuse a split with undeclared groups on both sides, by a ValueError."""
        if not len(self.train) or not len(self.test):
            raise ValueError(f"split {self.name!r} has an empty side")
        if len(np.intersect1d(self.train, self.test)):
            raise ValueError(f"split {self.name!r} has a pinch on both sides")
        for group, names in ((Group.SESSION, sessions), (Group.SPECIMEN, specimens)):
            both = set(names[self.train]) & set(names[self.test])
            if both and group not in self.shares:
                raise ValueError(
                    f"split {self.name!r} has the {group} {str(min(both))!r} on both sides, which "
                    "the field 'shares' does not declare"
                )


def by_session(
    sessions: NDArray[np.str_], classes: NDArray[Any], seed: int, folds: int = FOLDS
) -> list[Split]:
    """Return folds that hold out whole sessions, with each class spread evenly over the folds."""
    from sklearn.model_selection import GroupKFold, StratifiedGroupKFold

    names = np.unique(sessions)
    if len(names) < 2 or "" in names:
        raise ValueError("a split by session needs pinches of two known sessions or more")
    folds = min(folds, len(names))
    # scikit-learn refuses to stratify by fractional values.
    _, strata, counts = np.unique(classes, return_inverse=True, return_counts=True)
    # Small classes cannot be stratified; sessions stay whole either way.
    splitter = (
        StratifiedGroupKFold(folds, shuffle=True, random_state=seed)
        if counts.min() >= folds
        else GroupKFold(folds)
    )
    dealt = splitter.split(np.zeros((len(classes), 1)), strata, groups=sessions)
    return [
        Split(f"sessions {i}", train, test, frozenset({Group.SPECIMEN}))
        for i, (train, test) in enumerate(dealt)
        if len(train) and len(test)
    ]


def leave_one_out(values: NDArray[Any], shares: Sequence[Group] = (Group.SESSION,)) -> list[Split]:
    """Return splits that hold out each level, material or specimen in turn."""
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
    """Yield folds that hold out whole sessions, with similar targets in each fold."""
    from sklearn.model_selection import StratifiedGroupKFold, StratifiedKFold

    if groups is not None and len(np.unique(groups)) < 2:
        groups = None
    k = min(k, len(y) if groups is None else len(np.unique(groups)))
    if k < 2:
        return
    kind = StratifiedKFold if groups is None else StratifiedGroupKFold
    folds = kind(k, shuffle=True, random_state=seed)
    for train, validation in folds.split(y[:, None], _strata(y, k), groups):
        if len(validation):
            yield train, validation


def _strata(y: NDArray[Any], k: int) -> NDArray[np.intp]:
    """Return the class number of each target; all 0 if a class is too rare for k folds."""
    values, numbers = np.unique(y, return_inverse=True)
    if len(values) > RANGES:
        edges = np.quantile(y, np.arange(1, RANGES) / RANGES)
        numbers = np.unique(np.searchsorted(edges, y, side="right"), return_inverse=True)[1]
    rare = np.bincount(numbers).min() < k
    return np.zeros(len(y), dtype=np.intp) if rare else numbers
