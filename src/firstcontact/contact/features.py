"""What the SVM sees of a window."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

#: Parts that the quiet side is summed up in, and each step of the recent side.
PARTS = 3
#: The step before the newest is averaged to so many values.
COARSE = 5
#: Added to an rms, in sigmas, before its logarithm: below it nothing matters.
FLOOR = 0.1


def feature_count(step: int) -> int:
    """Features of a window with ``step`` new samples."""
    return step + COARSE + 6 * PARTS + 2


def _means(x: NDArray[np.float64], edges: NDArray[np.intp]) -> NDArray[np.float64]:
    """Mean between neighbouring edges, shape (windows, parts)."""
    sums = np.add.reduceat(x, edges[:-1], axis=1)
    out: NDArray[np.float64] = sums / np.diff(edges)
    return out


@lru_cache(maxsize=64)
def _edges(start: int, stop: int, parts: int) -> NDArray[np.intp]:
    return np.linspace(start, stop, parts + 1).astype(np.intp)


def window_features(windows: NDArray[np.float64], step: int) -> NDArray[np.float64]:
    """Shape of the recent part, and how loud each part is.

    The newest two steps are recent: a contact that is still faint in one
    window can show in the next. The rest is quiet and gives the mean. Features
    are the newest step's samples and the means of the step before, compressed
    by asinh so that a loud contact and a faint one lie close together; the
    logarithmic rms of three quiet and of six recent parts, of the signal and
    of its differences (short clicks and slow contacts differ in their ratio);
    and how far the recent peaks exceed the quiet ones.

    Parameters
    ----------
    windows
        Shape (windows, samples), in sigmas of the steady state; more samples
        than two steps.
    step
        Samples in the new part.

    Returns
    -------
    ndarray
        Shape (windows, :func:`feature_count`).
    """
    n = windows.shape[1]
    new, quiet = n - step, n - 2 * step
    centred = windows - windows[:, :quiet].mean(axis=1, keepdims=True)
    slope = np.zeros_like(centred)
    np.subtract(centred[:, 1:], centred[:, :-1], out=slope[:, 1:])
    edges = np.concatenate(
        [_edges(0, quiet, PARTS), _edges(quiet, new, PARTS)[1:], _edges(new, n, PARTS)[1:]]
    )
    loudness = [np.log(np.sqrt(_means(x**2, edges)) + FLOOR) for x in (centred, slope)]
    peaks = [
        np.log(np.abs(x[:, quiet:]).max(axis=1, keepdims=True) + FLOOR)
        - np.log(np.abs(x[:, :quiet]).max(axis=1, keepdims=True) + FLOOR)
        for x in (centred, slope)
    ]
    before = _means(centred[:, :new], _edges(quiet, new, COARSE))
    return np.concatenate(
        [np.arcsinh(centred[:, new:]), np.arcsinh(before), *loudness, *peaks], axis=1
    )
