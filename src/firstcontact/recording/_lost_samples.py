"""Places of lost samples, from regular or jittering time stamps of a whole stream.

``firstcontact.device._stamped_samples`` detects losses in a live stream, before later samples are
known. Here, both sides of a loss are compared, so that a delay is no loss.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

#: Stamps are regular if no step is too short by this many samples or more, and more than this share
#: of the steps is off by less.
_STEADY, _MOST = 0.25, 0.7
#: Jittering stamps are compared as medians of blocks of this length, s.
_BLOCK = 0.2
#: Largest and smallest number of blocks that are compared on each side of a loss.
_LARGEST, _FEWEST = 25, 8
#: Number of blocks on each side that may be off, because of delays.
_OUTLIERS = 2
#: Numbers of blocks between two whose difference gives the rate. Several numbers, because blocks of
#: a sender beat with our blocks.
_LAGS = range(5, 15)
#: Smallest loss that is detected in jittering stamps, s, and in samples.
_SMALLEST, _SMALLEST_SAMPLES = 0.001, 2.0


def lost_samples(stamps: NDArray[np.float64], rate: float) -> list[int]:
    """Return the number of the first sample after each loss."""
    errors = np.diff(stamps) * rate - 1.0  # of the steps, in samples
    if len(errors) and errors.min() > -_STEADY and np.mean(errors < _STEADY) > _MOST:
        after_loss: list[int] = (np.flatnonzero(errors > 1 - _STEADY) + 1).tolist()
        return after_loss
    size = math.ceil(_BLOCK * rate)
    n = len(stamps) // size
    levels = np.median(stamps[: n * size].reshape(n, size), axis=1)
    places, stretches = [], [(0, n)]
    while stretches:
        first, end = stretches.pop()
        if end - first < 2 * _FEWEST:
            continue
        pace = _pace(levels[first:end])
        lateness = levels[first:end] - pace * np.arange(first, end)
        rises, falls = (_rises(x)[_FEWEST:-_FEWEST] for x in (lateness, -lateness))
        k = int(np.argmax(rises))
        # Delays end: they have falls as large as their rises.
        if rises[k] < max(_SMALLEST, _SMALLEST_SAMPLES / rate, 1.5 * falls.max()):
            continue
        k += _FEWEST
        # Of all places near k, two levels explain the stamps best with a change at this one.
        early = np.median(lateness[max(0, k - _LARGEST) : k])
        late = np.median(lateness[k : k + _LARGEST])
        near = (first + k) * size + np.arange(-(_OUTLIERS + 1) * size, (_OUTLIERS + 1) * size)
        each = stamps[near] - pace * (near - (size - 1) / 2) / size
        misfit = np.cumsum(np.abs(each - early) - np.abs(each - late))
        place = int(near[np.argmin(misfit)]) + 1
        places.append(place)
        stretches += [(first, round(place / size)), (round(place / size), end)]
    return sorted(places)


def _pace(levels: NDArray[np.float64]) -> float:
    """Return the median rise of levels from block to block. Jumps hardly change it."""
    rises = [(levels[lag:] - levels[:-lag]) / lag for lag in _LAGS]
    return float(np.median(np.concatenate(rises)))


def _rises(levels: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rise of the levels at each border of blocks, without outliers."""
    padding = np.full(_LARGEST, np.inf)
    padded = [np.concatenate([levels, padding]), np.concatenate([padding, -levels])]
    windows = np.lib.stride_tricks.sliding_window_view(padded, _LARGEST, axis=1)
    lowest, highest = np.partition(windows, _OUTLIERS, axis=2)[:, :, _OUTLIERS]
    rises: NDArray[np.float64] = lowest + highest
    return rises
