"""Splits of pinches as in the paper, and checks that scores on a split make sense."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.models import Group, Split

#: Largest number of random folds.
FOLDS = 5
#: Share of the pinches that the paper's random split keeps for testing.
RANDOM_TEST = 0.1


def random_90_10(classes: NDArray[Any], seed: int) -> list[Split]:
    """Return the paper's split: 90 % of the pinches for training, drawn at random by class."""
    from sklearn.model_selection import StratifiedShuffleSplit

    splitter = StratifiedShuffleSplit(1, test_size=RANDOM_TEST, random_state=seed)
    shares = frozenset({Group.SESSION, Group.SPECIMEN})
    # scikit-learn refuses to stratify by fractional values.
    strata = np.unique(classes, return_inverse=True)[1]
    return [
        Split("random_90_10", train, test, shares)
        for train, test in splitter.split(classes[:, None], strata)
    ]


def random_folds(classes: NDArray[Any], seed: int, folds: int = FOLDS) -> list[Split]:
    """Return random stratified folds. Scores on them are optimistic: use them for comparison."""
    from sklearn.model_selection import StratifiedKFold

    _, strata, counts = np.unique(classes, return_inverse=True, return_counts=True)
    fewest = int(counts.min(initial=len(classes)))
    if fewest < 2:
        raise ValueError("random folds need at least two pinches of each class")
    splitter = StratifiedKFold(min(folds, fewest), shuffle=True, random_state=seed)
    shares = frozenset({Group.SESSION, Group.SPECIMEN})
    return [
        Split(f"random fold {i}", train, test, shares)
        for i, (train, test) in enumerate(splitter.split(classes[:, None], strata))
    ]


def unseen_objects(test: NDArray[np.bool_], shares: Sequence[Group] = ()) -> Split:
    """Return the split that trains on pinches of role ``train`` and tests on role ``test``."""
    learn, ask = np.flatnonzero(~test), np.flatnonzero(test)
    return Split("unseen objects", learn, ask, frozenset(shares))


def learns_one_value(splits: Sequence[Split], values: NDArray[Any]) -> bool:
    """Return True if the training side of some split has fewer than two distinct values."""
    return any(len(np.unique(values[split.train])) < 2 for split in splits)


def never_learned(splits: Sequence[Split], classes: NDArray[Any]) -> NDArray[Any]:
    """Return the classes that some split tests, but does not have in its training data."""
    lacking = [np.setdiff1d(classes[split.test], classes[split.train]) for split in splits]
    return np.unique(np.concatenate(lacking)) if lacking else classes[:0]
