"""Picker for the onset of a contact in a window."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

#: Fewest samples on the loud side, needed for a variance.
LEAST_LOUD = 3


def pick_onset(windows: NDArray[np.float64], search: int) -> NDArray[np.intp]:
    """Return the split of each window that best separates quiet from loud.

    Maeda's picker (1985, Zisin 38, 365) minimises ``AIC(k) = k log var(x[:k]) + (n - k - 1) log
    var(x[k:])`` over the split k. It needs neither a threshold nor samples after the window.

    Parameters
    ----------
    windows
        Windows, shape (windows, samples), in sigmas of the steady state.
    search
        Number of newest samples that may hold the onset.

    Returns
    -------
    ndarray
        Position of the first loud sample in each window, shape (windows,).
    """
    n = windows.shape[1]
    first = max(LEAST_LOUD, n - search)
    splits = np.arange(first, n - LEAST_LOUD + 1)
    sums = np.cumsum(windows, axis=1)
    squares = np.cumsum(windows**2, axis=1)
    left, left_squares = sums[:, splits - 1], squares[:, splits - 1]
    right, right_squares = sums[:, -1:] - left, squares[:, -1:] - left_squares
    quiet = left_squares / splits - (left / splits) ** 2
    loud = right_squares / (n - splits) - (right / (n - splits)) ** 2
    # A millionth of the steady variance keeps the logarithm of a flat part finite.
    quiet, loud = np.maximum(quiet, 1e-6), np.maximum(loud, 1e-6)
    aic = splits * np.log(quiet) + (n - splits - 1) * np.log(loud)
    picked: NDArray[np.intp] = splits[np.argmin(aic, axis=1)]
    return picked
