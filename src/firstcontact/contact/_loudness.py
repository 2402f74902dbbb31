"""Loudness features: levels of a window's newest samples relative to its quiet part."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz

from firstcontact.signal import samples_in

#: Lengths of the newest parts, s: from two samples to three milliseconds.
PARTS = (0.0004, 0.0008, 0.0014, 0.0022, 0.003)
#: Length of the recent part at the end of a window, s. The rest is the quiet part.
RECENT = 0.006
#: Order of the linear prediction, and the share of white noise that regularises it.
ORDER = 12
RIDGE = 1e-3
#: Added to a level, in sigmas, before its logarithm. Smaller levels do not matter.
FLOOR = 0.1
#: Up to this number of windows, the samples for all taps fit into the fastest cache.
FEW = 8
#: Number of features of the signal, and of its prediction error.
EACH = len(PARTS) + 3


def prediction(quiet: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a filter that removes the predictable part of the motor's noise.

    The filter is a linear prediction (Yule-Walker) from the steady state. Motor spectra and ringing
    sensors differ between rigs, but the prediction error is white on all of them.

    Parameters
    ----------
    quiet
        Samples of one channel in the steady state, in its sigmas, shape (samples,).

    Returns
    -------
    ndarray
        Weights of the newest sample and of the samples before it, shape (ORDER + 1,). With them the
        prediction error of ``quiet`` has a sigma of 1.
    """
    n = len(quiet)
    lags = np.array([quiet[: n - k] @ quiet[k:] for k in range(ORDER + 1)]) / n
    if not lags[0] > 0.0:
        return np.zeros(ORDER + 1)
    lags[0] *= 1.0 + RIDGE
    weights = np.concatenate([[1.0], -solve_toeplitz(lags[:-1], lags[1:])])
    sigma = prediction_error(quiet, weights).std()
    out: NDArray[np.float64] = weights / sigma if sigma > 0.0 else 0.0 * weights
    return out


def prediction_error(x: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the prediction error of ``x`` along the last axis. It is ``ORDER`` samples shorter.

    ``weights`` come from :func:`prediction`, shape (..., ORDER + 1).
    """
    n = x.shape[-1] - ORDER
    if (
        x.ndim == 2 and len(x) <= FEW and x.flags.c_contiguous
    ):  # the same sums with fewer calls, for live windows
        row, sample = x.strides
        taps: NDArray[np.float64] = np.ndarray(
            (ORDER + 1, len(x), n), x.dtype, x, ORDER * sample, (-sample, row, sample)
        )
        error: NDArray[np.float64] = np.add.reduce(weights.T[:, :, None] * taps, axis=0)
        return error
    # A loop over the taps rounds the same for any number of windows. A matrix product may not.
    out = np.array(weights[..., :1] * x[..., ORDER:])
    for k in range(1, ORDER + 1):
        out += weights[..., k : k + 1] * x[..., ORDER - k : ORDER - k + n]
    return out


@lru_cache(maxsize=64)
def _edges(n: int, rate: float) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Return the edges of a window's pieces, and the divisors that turn their sums into levels.

    The quiet part is the first piece. The divisors have the shape (2, 1, EACH + 1).
    """
    lengths = parts(rate)
    edges = np.array([0, *(n - k for k in lengths[::-1])])
    divisors = np.ones((2, 1, EACH + 1))
    divisors[:, 0, 0] = edges[1] - np.array([0, ORDER])
    divisors[:, :, 1:-3] = lengths[:-1]
    divisors[:, :, -3] = edges[2] - edges[1]
    return edges, divisors


def parts(rate: float) -> list[int]:
    """Return the lengths of spans that end with a window, ascending, in samples.

    The last one is the recent part. The samples before it are the quiet part.
    """
    lengths: list[int] = []
    for part in (*PARTS, RECENT):
        lengths.append(max(samples_in(part, rate), lengths[-1] + 1 if lengths else 1))
    return lengths


def logarithm_weights(weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Convert weights of loudness features to weights of logarithms of levels.

    The features are differences of these logarithms. ``weights`` has the shape (2 * EACH,). The
    result has the shape (2, EACH + 1): a row for the signal and one for its prediction error. The
    order in a row is: spans of the newest 3 ms, quiet part, the 3 ms between them, peak of the
    newest 3 ms, peak of the quiet part.
    """
    out = []
    for quiet, *newest, between, peak in weights.reshape(2, EACH):
        out.append([*newest, quiet - sum(newest) - between, between, peak, -peak])
    return np.array(out)


def loudness_features(
    windows: NDArray[np.float64], weights: NDArray[np.float64], rate: float
) -> NDArray[np.float64]:
    """Return the loudness features of windows: of the signal, then of its prediction error.

    Each of the two has the same features, all logarithms. The first is the level of the quiet part.
    The next are the levels of five spans at the end of the window, 0.4 to 3 ms long, relative to
    the quiet part. Then comes the level of the 3 ms before these spans, relative to the quiet part.
    The last is the peak of the newest 3 ms, relative to the peak of the quiet part.

    Parameters
    ----------
    windows
        Shape (windows, samples), in sigmas of the steady state.
    weights
        Weights of :func:`prediction` for each window, shape (windows, ORDER + 1).
    rate
        Sampling rate, Hz.

    Returns
    -------
    ndarray
        Shape (windows, 2 * EACH).
    """
    count, n = windows.shape
    edges, divisors = _edges(n, rate)
    # Row 0 is the signal, row 1 its prediction error: each operation below handles both. The error
    # is shorter, so its quiet part begins with zeros.
    both = np.zeros((2, count, n))
    quiet = np.add.reduce(windows[:, : edges[1]], axis=1, keepdims=True) / edges[1]
    np.subtract(windows, quiet, out=both[0])
    both[1, :, ORDER:] = prediction_error(windows, weights)
    np.multiply(both, both, out=both)
    sums = np.add.reduceat(both, edges, axis=2)
    tops = np.maximum.reduceat(both, edges[:3], axis=2)
    levels = np.empty((2, count, EACH + 1))
    levels[:, :, 0] = sums[:, :, 0]
    np.cumsum(sums[:, :, :1:-1], axis=2, out=levels[:, :, 1:-3])
    levels[:, :, -3] = sums[:, :, 1]
    levels[:, :, -2] = tops[:, :, 2]
    levels[:, :, -1] = tops[:, :, 0]
    levels /= divisors
    logs = np.log(np.sqrt(levels) + FLOOR)
    out = np.empty((count, 2, EACH))
    by_window = logs.transpose(1, 0, 2)
    out[:, :, 0] = by_window[:, :, 0]
    np.subtract(by_window[:, :, 1:-2], by_window[:, :, :1], out=out[:, :, 1:-1])
    np.subtract(by_window[:, :, -2], by_window[:, :, -1], out=out[:, :, -1])
    return out.reshape(count, 2 * EACH)
