"""How much louder the newest part of a window is than what went before, in the rig's own units."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz

from firstcontact.signal import samples_in

#: The newest parts whose loudness is looked at, s: from two samples to three milliseconds.
PARTS = (0.0004, 0.0008, 0.0014, 0.0022, 0.003)
#: So much at the end of a window is not quiet any more when a contact has begun, s.
RECENT = 0.006
#: Order of the prediction, and the share of white noise that keeps it well posed.
ORDER = 12
RIDGE = 1e-3
#: Added to a level, in sigmas, before its logarithm: below it nothing matters.
FLOOR = 0.1
#: Features of each of the two signals.
EACH = len(PARTS) + 3


def prediction(quiet: NDArray[np.float64]) -> NDArray[np.float64]:
    """Filter that leaves of the motor only what could not be foretold.

    Linear prediction (Yule-Walker) from the steady state: lines and colour of a motor, and the
    ringing of a sensor, are different on each rig, and what is left of them is white on all.

    Parameters
    ----------
    quiet
        Steady state of one channel, in its sigmas, shape (samples,).

    Returns
    -------
    ndarray
        Weights of the newest sample and of those before it, so that what is left of ``quiet``
        has a sigma of 1, shape (ORDER + 1,).
    """
    n = len(quiet)
    lags = np.array([quiet[: n - k] @ quiet[k:] for k in range(ORDER + 1)]) / n
    if not lags[0] > 0.0:
        return np.zeros(ORDER + 1)
    lags[0] *= 1.0 + RIDGE
    weights = np.concatenate([[1.0], -solve_toeplitz(lags[:-1], lags[1:])])
    sigma = left(quiet, weights).std()
    out: NDArray[np.float64] = weights / sigma if sigma > 0.0 else 0.0 * weights
    return out


def left(x: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """What of the last axis its past does not foretell, ``ORDER`` samples shorter.

    ``weights`` of :func:`prediction`, shape (..., ORDER + 1).
    """
    n = x.shape[-1] - ORDER
    # Tap by tap: the same numbers however many windows there are, which a product of
    # matrices does not promise.
    out = np.array(weights[..., :1] * x[..., ORDER:])
    for k in range(1, ORDER + 1):
        out += weights[..., k : k + 1] * x[..., ORDER - k : ORDER - k + n]
    return out


@lru_cache(maxsize=64)
def _edges(n: int, rate: float) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Where the parts of a window begin, quiet first, and how long each is with all after it."""
    lengths = parts(rate)
    return np.array([0, *(n - k for k in lengths[::-1])]), np.array(lengths[:-1], dtype=np.float64)


def parts(rate: float) -> list[int]:
    """Samples in the newest parts, ascending, and last in what is not quiet any more."""
    lengths: list[int] = []
    for part in (*PARTS, RECENT):
        lengths.append(max(samples_in(part, rate), lengths[-1] + 1 if lengths else 1))
    return lengths


def of_logarithms(weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights of the logarithms that :func:`loudness_features` takes differences of.

    Of each signal: the newest parts, the quiet part, what lies between, the highest peak, the
    quiet part's. Shape (2 * EACH,) to (2, EACH + 1).
    """
    out = []
    for quiet, *newest, between, peak in weights.reshape(2, EACH):
        out.append([*newest, quiet - sum(newest) - between, between, peak, -peak])
    return np.array(out)


def loudness_features(
    windows: NDArray[np.float64], weights: NDArray[np.float64], rate: float
) -> NDArray[np.float64]:
    """Logarithms of levels, of the signal and of what is new in it.

    Of each: how loud the quiet part is, by how much the newest parts, the 3 ms before them and
    the highest peak of the newest 3 ms exceed it.

    Parameters
    ----------
    windows
        Shape (windows, samples), in sigmas of the steady state.
    weights
        Of :func:`prediction`, of each window, shape (windows, ORDER + 1).
    rate
        Sampling rate, Hz.

    Returns
    -------
    ndarray
        Shape (windows, 2 * EACH).
    """
    out = np.empty((len(windows), 2, EACH))
    n = windows.shape[1]
    edges, _ = _edges(n, rate)
    quiet = np.add.reduce(windows[:, : edges[1]], axis=1, keepdims=True) / edges[1]
    for into, x in zip((0, 1), (windows - quiet, left(windows, weights)), strict=True):
        power = x**2
        edges, lengths = _edges(x.shape[1], rate)
        sums = np.add.reduceat(power, edges, axis=1)
        tops = np.maximum.reduceat(power, edges[[0, 1, 2]], axis=1)
        levels = np.concatenate(
            [
                sums[:, :1] / edges[1],
                np.cumsum(sums[:, :1:-1], axis=1) / lengths,
                sums[:, 1:2] / (edges[2] - edges[1]),
                tops[:, 2:],
                tops[:, :1],
            ],
            axis=1,
        )
        logs = np.log(np.sqrt(levels) + FLOOR)
        out[:, into, 0] = logs[:, 0]
        out[:, into, 1:-1] = logs[:, 1:-2] - logs[:, :1]
        out[:, into, -1] = logs[:, -2] - logs[:, -1]
    return out.reshape(len(windows), 2 * EACH)
