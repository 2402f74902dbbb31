"""Function that locates the onset of a contact in a window."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

#: Fewest samples on each side, needed for a variance.
LEAST_LOUD = 3


def pick_onset(windows: NDArray[np.float64], search: int) -> NDArray[np.intp]:
    """Return the split of each window that best separates quiet from loud."""
    n = windows.shape[1]
    first = max(LEAST_LOUD, n - search)
    counts, weights = _sides(n, first)
    # Row 0 is the quiet side of each split, row 1 the loud side.
    means = np.empty((2, len(windows), counts.shape[2]))
    variances = np.empty_like(means)
    for out, x in ((means, windows), (variances, windows**2)):
        sums = np.cumsum(x, axis=1)
        out[0] = sums[:, first - 1 : n - LEAST_LOUD]
        np.subtract(sums[:, -1:], out[0], out=out[1])
        out /= counts
    variances -= means**2
    # A millionth of the steady variance keeps the logarithm of a flat part finite.
    np.maximum(variances, 1e-6, out=variances)
    aic = (weights * np.log(variances)).sum(axis=0)
    picked: NDArray[np.intp] = first + np.argmin(aic, axis=1)
    return picked


@lru_cache(maxsize=64)
def _sides(n: int, first: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the sample counts and the weights of both sides of each split."""
    left = np.arange(first, n - LEAST_LOUD + 1, dtype=np.float64)
    counts = np.stack([left, n - left])[:, None]
    weights = np.stack([left, n - left - 1])[:, None]
    return counts, weights
