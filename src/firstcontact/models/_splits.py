"""Splits into training and test data that declare what both sides share."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

Index = NDArray[np.intp]
#: Folds of a split by session, where there are that many sessions.
FOLDS = 5


class Group(StrEnum):
    """Kind of group that a split may have on both sides."""

    SESSION = "session"
    SPECIMEN = "specimen"


@dataclass(frozen=True, slots=True, eq=False)
class Split:
    """Positions to learn from and positions to be asked about.

    Parameters
    ----------
    name
        Unique within a list of splits: the held-out fold, level or specimen.
    train, test
        Positions, each shape (n,).
    shares
        Groups that may lie on both sides. Everything else must not:
        :meth:`check`.
    """

    name: str
    train: Index
    test: Index
    shares: frozenset[Group] = field(default_factory=frozenset)

    def check(self, sessions: NDArray[np.str_], specimens: NDArray[np.str_]) -> None:
        """Refuse a split that mixes what it does not say it mixes.

        Parameters
        ----------
        sessions, specimens
            Of every pinch, shape (pinches,); "" is not known and cannot be
            told apart, so it counts as shared.

        Raises
        ------
        ValueError
            A pinch, session or specimen on both sides, or an empty side.
        """
        if not len(self.train) or not len(self.test):
            raise ValueError(f"split {self.name!r} has an empty side")
        if len(np.intersect1d(self.train, self.test)):
            raise ValueError(f"split {self.name!r} has a pinch on both sides")
        for group, names in ((Group.SESSION, sessions), (Group.SPECIMEN, specimens)):
            both = set(names[self.train]) & set(names[self.test])
            if both and group not in self.shares:
                raise ValueError(
                    f"split {self.name!r} has the {group} {str(min(both))!r} on both sides "
                    "and does not say so"
                )


def by_session(
    sessions: NDArray[np.str_], classes: NDArray[Any], seed: int, folds: int = FOLDS
) -> list[Split]:
    """Whole sessions held out, classes spread over the folds as well as sessions allow.

    Shares specimens: a set with one block a Shore level has no other choice.

    Raises
    ------
    ValueError
        Fewer than two sessions, or a pinch whose session is not known.
    """
    from sklearn.model_selection import GroupKFold, StratifiedGroupKFold

    names = np.unique(sessions)
    if len(names) < 2 or "" in names:
        raise ValueError("a split by session needs two known sessions or more")
    folds = min(folds, len(names))
    fewest = int(np.unique(classes, return_counts=True)[1].min())
    # Small classes cannot be stratified; sessions stay whole either way.
    splitter = (
        StratifiedGroupKFold(folds, shuffle=True, random_state=seed)
        if fewest >= folds
        else GroupKFold(folds)
    )
    dealt = splitter.split(np.zeros((len(classes), 1)), classes, groups=sessions)
    return [
        Split(f"sessions {i}", train, test, frozenset({Group.SPECIMEN}))
        for i, (train, test) in enumerate(dealt)
        if len(train) and len(test)
    ]


def leave_one_out(values: NDArray[Any], shares: Sequence[Group] = (Group.SESSION,)) -> list[Split]:
    """Hold out each level, material or specimen in turn.

    Parameters
    ----------
    values
        Shore level, material or specimen of each pinch, shape (pinches,).
    shares
        What the sides still have in common; sessions, as a session usually
        holds several objects.
    """
    everyone = np.arange(len(values))
    return [
        Split(
            f"without {value}",
            everyone[values != value],
            everyone[values == value],
            frozenset(shares),
        )
        for value in np.unique(values)
        if (values != value).any()
    ]


#: Targets of more values than this are cut into as many ranges to spread them over the folds.
RANGES = 5


def inner_folds(
    y: NDArray[Any], groups: NDArray[Any] | None, seed: int, k: int = 3
) -> Iterator[tuple[Index, Index]]:
    """Folds that keep a session on one side, where there is more than one, and spread targets.

    Parameters
    ----------
    y
        Targets, shape (n,).
    groups
        Session of each window, shape (n,); None or a single one: windows are dealt.
    seed
        Of the shuffling.
    k
        Folds; fewer when there are fewer sessions.

    Yields
    ------
    train, validation
        Positions, ascending. Each position is in one validation; none of both is empty.
    """
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
