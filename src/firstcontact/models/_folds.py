"""Inner folds: what is chosen during training is chosen on sessions not learned from."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

Index = NDArray[np.intp]
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
    """Number of each target's value or range; all 0 where some are too rare for k folds."""
    values, numbers = np.unique(y, return_inverse=True)
    if len(values) > RANGES:
        edges = np.quantile(y, np.arange(1, RANGES) / RANGES)
        numbers = np.unique(np.searchsorted(edges, y, side="right"), return_inverse=True)[1]
    rare = np.bincount(numbers).min() < k
    return np.zeros(len(y), dtype=np.intp) if rare else numbers
