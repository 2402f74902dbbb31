"""Splits of the study: the paper's splits, and checks of their scores."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.models import Group, Split

#: Most random folds.
FOLDS = 5
#: Share of the pinches that the paper's random split keeps for testing.
RANDOM_TEST = 0.1


def random_90_10(classes: NDArray[Any], seed: int) -> list[Split]:
    """Split at random, stratified: what the paper did. Shares sessions and specimens."""
    from sklearn.model_selection import StratifiedShuffleSplit

    splitter = StratifiedShuffleSplit(1, test_size=RANDOM_TEST, random_state=seed)
    shares = frozenset({Group.SESSION, Group.SPECIMEN})
    return [
        Split("random_90_10", train, test, shares)
        for train, test in splitter.split(classes[:, None], classes)
    ]


def random_folds(classes: NDArray[Any], seed: int, folds: int = FOLDS) -> list[Split]:
    """Cut at random into stratified folds: optimistic, a warning beside honest splits.

    Raises
    ------
    ValueError
        A class with fewer than two pinches, or no pinch at all.
    """
    from sklearn.model_selection import StratifiedKFold

    fewest = int(np.unique(classes, return_counts=True)[1].min(initial=len(classes)))
    if fewest < 2:
        raise ValueError("random folds need two pinches of each class or more")
    splitter = StratifiedKFold(min(folds, fewest), shuffle=True, random_state=seed)
    shares = frozenset({Group.SESSION, Group.SPECIMEN})
    return [
        Split(f"random fold {i}", train, test, shares)
        for i, (train, test) in enumerate(splitter.split(classes[:, None], classes))
    ]


def unseen_objects(test: NDArray[np.bool_], shares: Sequence[Group] = ()) -> Split:
    """Learn from all pinches with the role ``train``, ask about those with ``test``."""
    learn, ask = np.flatnonzero(~test), np.flatnonzero(test)
    return Split("unseen objects", learn, ask, frozenset(shares))


def learns_one_value(splits: Sequence[Split], values: NDArray[Any]) -> bool:
    """Return True if some training side has fewer than two values."""
    return any(len(np.unique(values[split.train])) < 2 for split in splits)


def never_learned(splits: Sequence[Split], classes: NDArray[Any]) -> NDArray[Any]:
    """Classes that some split asks about without having learned them, ascending.

    No model can answer with them: an accuracy over such a split says nothing.
    """
    lacking = [np.setdiff1d(classes[split.test], classes[split.train]) for split in splits]
    return np.unique(np.concatenate(lacking)) if lacking else classes[:0]
