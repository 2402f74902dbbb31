"""Features of a window for the SVM detector."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

#: Number of parts into which the quiet part of a window, and each of its two recent steps, is
#: divided.
PARTS = 3
#: Number of means that describe the step before the newest step.
COARSE = 5
#: Added to an RMS, in sigmas, before its logarithm. Smaller levels do not matter.
FLOOR = 0.1


def feature_count(step: int) -> int:
    """Return the number of features of a window whose newest step has ``step`` samples."""
    return step + COARSE + 6 * PARTS + 2


@dataclass(frozen=True, slots=True, eq=False)
class _Edges:
    """Starts and widths of the pieces of a window, in samples."""

    starts: NDArray[np.intp]
    widths: NDArray[np.intp]


def _means(x: NDArray[np.float64], edges: _Edges) -> NDArray[np.float64]:
    """Return the mean of each piece along the last axis."""
    out: NDArray[np.float64] = np.add.reduceat(x, edges.starts, axis=-1) / edges.widths
    return out


@lru_cache(maxsize=64)
def _part_edges(start: int, stop: int, parts: int) -> _Edges:
    edges = np.linspace(start, stop, parts + 1).astype(np.intp)
    return _Edges(edges[:-1], np.diff(edges))


@lru_cache(maxsize=64)
def _loudness_edges(quiet: int, new: int, n: int) -> _Edges:
    """Return the edges of nine pieces: three of the quiet samples and three of each recent step."""
    parts = [_part_edges(*span, PARTS) for span in ((0, quiet), (quiet, new), (new, n))]
    starts, widths = ([getattr(p, name) for p in parts] for name in ("starts", "widths"))
    return _Edges(np.concatenate(starts), np.concatenate(widths))


def edges(samples: int, step: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the starts of the pieces for loudness, and of the pieces for means, in samples."""
    new, quiet = samples - step, samples - 2 * step
    coarse = _part_edges(quiet, new, COARSE).starts
    return (
        np.append(_loudness_edges(quiet, new, samples).starts, samples),
        np.append(coarse, new),
    )


def window_features(windows: NDArray[np.float64], step: int) -> NDArray[np.float64]:
    """Return features of windows: their newest waveform, and the loudness of nine pieces of each.

    The newest two steps of a window are recent, because a contact that is faint in one window can
    show in the next. The samples before them are quiet. Their mean is subtracted from the window.
    The features are:

    - the samples of the newest step, and means of the step before it, compressed by asinh, so that
      loud and faint contacts lie close together;
    - the logarithmic RMS of three quiet and six recent pieces, both of the signal and of the
      differences between its samples. Their ratio separates short clicks from slow contacts;
    - the logarithm of the recent peak divided by the quiet peak, of the signal and of the
      differences.
    """
    count, n = windows.shape
    new, quiet = n - step, n - 2 * step
    # Row 0 is the signal, row 1 its differences. Each operation below handles both.
    both = np.zeros((2, count, n))
    centred, slope = both
    np.subtract(windows, windows[:, :quiet].mean(axis=1, keepdims=True), out=centred)
    np.subtract(centred[:, 1:], centred[:, :-1], out=slope[:, 1:])
    loudness = np.log(np.sqrt(_means(both**2, _loudness_edges(quiet, new, n))) + FLOOR)
    tops = np.log(np.maximum.reduceat(np.abs(both), (0, quiet), axis=2) + FLOOR)
    peaks = tops[:, :, 1] - tops[:, :, 0]
    recent_means = _means(centred[:, :new], _part_edges(quiet, new, COARSE))
    return np.concatenate(
        [np.arcsinh(centred[:, new:]), np.arcsinh(recent_means), *loudness, peaks.T], axis=1
    )
