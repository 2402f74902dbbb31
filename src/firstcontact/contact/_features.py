"""What the SVM sees of a window."""

from __future__ import annotations

from dataclasses import dataclass
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


@dataclass(frozen=True, slots=True, eq=False)
class _Edges:
    """Where parts of a window begin, and how many samples each has."""

    starts: NDArray[np.intp]
    widths: NDArray[np.intp]


def _means(x: NDArray[np.float64], edges: _Edges) -> NDArray[np.float64]:
    """Mean of each part along the last axis."""
    out: NDArray[np.float64] = np.add.reduceat(x, edges.starts, axis=-1) / edges.widths
    return out


@lru_cache(maxsize=64)
def _edges(start: int, stop: int, parts: int) -> _Edges:
    edges = np.linspace(start, stop, parts + 1).astype(np.intp)
    return _Edges(edges[:-1], np.diff(edges))


@lru_cache(maxsize=64)
def _loudness_edges(quiet: int, new: int, n: int) -> _Edges:
    """Three quiet parts, and three of each recent step."""
    parts = [_edges(*span, PARTS) for span in ((0, quiet), (quiet, new), (new, n))]
    starts, widths = ([getattr(p, name) for p in parts] for name in ("starts", "widths"))
    return _Edges(np.concatenate(starts), np.concatenate(widths))


def edges(samples: int, step: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Where parts begin whose loudness, and whose means, are features; the end of the last, too."""
    new, quiet = samples - step, samples - 2 * step
    coarse = _edges(quiet, new, COARSE).starts
    return (
        np.append(_loudness_edges(quiet, new, samples).starts, samples),
        np.append(coarse, new),
    )


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
    count, n = windows.shape
    new, quiet = n - step, n - 2 * step
    # The signal, and below it its differences: what follows is done to both at once.
    both = np.zeros((2, count, n))
    centred, slope = both
    np.subtract(windows, windows[:, :quiet].mean(axis=1, keepdims=True), out=centred)
    np.subtract(centred[:, 1:], centred[:, :-1], out=slope[:, 1:])
    loudness = np.log(np.sqrt(_means(both**2, _loudness_edges(quiet, new, n))) + FLOOR)
    tops = np.log(np.maximum.reduceat(np.abs(both), (0, quiet), axis=2) + FLOOR)
    peaks = tops[:, :, 1] - tops[:, :, 0]
    before = _means(centred[:, :new], _edges(quiet, new, COARSE))
    return np.concatenate(
        [np.arcsinh(centred[:, new:]), np.arcsinh(before), *loudness, peaks.T], axis=1
    )
