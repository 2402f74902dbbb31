"""Inner folds: what is chosen during training is chosen on sessions not learned from."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

Index = NDArray[np.intp]


def inner_folds(
    y: NDArray[Any], groups: NDArray[Any] | None, seed: int, k: int = 3
) -> Iterator[tuple[Index, Index]]:
    """Folds that keep a session on one side, where there is more than one.

    Sessions (or single windows, without sessions) are sorted by their mean
    target, shuffled among equals and dealt out like cards, so that each fold
    holds soft and hard ones.

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
        Positions, ascending.
    """
    if groups is None or len(np.unique(groups)) < 2:
        groups = np.arange(len(y))
    names, member = np.unique(groups, return_inverse=True)
    mean = np.bincount(member, weights=y) / np.bincount(member)
    shuffle = np.random.default_rng(seed).permutation(len(names))
    dealt = np.empty(len(names), dtype=np.intp)
    dealt[np.lexsort((shuffle, mean))] = np.arange(len(names)) % k
    fold = dealt[member]
    for number in range(min(k, len(names))):
        yield np.flatnonzero(fold != number), np.flatnonzero(fold == number)
