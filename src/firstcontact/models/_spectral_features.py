"""Gain-independent features of a window: its spectrum without the level, and its course in time.

Contacts with harder objects are shorter (Hertz), which shifts energy to higher frequencies and to
the start of the window. Loudness depends on the sensor more than on the object.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache

import numpy as np
from numpy.typing import NDArray

from firstcontact.models._spec import Values, Windows

#: Number of bands of the coarse spectrum, their lowest edge, Hz, and the padded length of windows.
BANDS = 16
LOWEST = 100.0
PADDED = 256
#: Added to a line's share of the energy before the logarithm, relative to an even share. Lines 30
#: dB below an even share are noise, whose level depends on the sensor.
FLOOR = 1e-3
#: Quantiles of the energy. The times at which they are reached describe the window.
QUANTILES = (0.10, 0.25, 0.50, 0.75, 0.90)
_TINY = 1e-300

Features = Callable[[Values, float], Values]


def features(kind: str, X: Windows, rate: float) -> Values:
    """Return the features (n, inputs) of windows (n, samples, channels); ``kind`` is in KINDS."""
    waves = X.astype(np.float64)
    # Then the squares of any finite floats stay within range.
    waves /= np.maximum(np.abs(waves).max(axis=(1, 2), keepdims=True), _TINY)
    return np.concatenate([KINDS[kind](waves[:, :, c], rate) for c in range(X.shape[2])], axis=1)


def log_bands(waves: Values, rate: float) -> Values:
    """Return the log spectrum without its level, in bands of equal ratio, shape (n, BANDS)."""
    padded = padded_length(waves.shape[1])
    return _level_free(_power(waves, padded) @ in_bands(padded, rate))


def padded_length(samples: int) -> int:
    """Return the length to which :func:`log_bands` pads windows with zeros."""
    return max(PADDED, 1 << (samples - 1).bit_length())


def log_bins(waves: Values, rate: float) -> Values:
    """Return the log spectrum without its level, shape (n, samples // 2 + 1)."""
    return _level_free(_power(waves, waves.shape[1]))


def course(waves: Values, rate: float) -> Values:
    """Return features of the windows' course in time, shape (n, 8)."""
    n = waves.shape[1]
    energy = np.cumsum(waves**2, axis=1)
    total = np.maximum(energy[:, -1:], _TINY)
    come = np.stack([(energy < q * total).sum(axis=1) / n for q in QUANTILES], axis=1)
    signs = np.sign(waves)
    turns = (signs[:, 1:] != signs[:, :-1]).mean(axis=1)
    steps = (np.diff(waves, axis=1) ** 2).sum(axis=1)
    rough = np.log(np.maximum(steps, _TINY) / total[:, 0])
    peak = np.abs(waves).argmax(axis=1) / n
    return np.column_stack([come, turns, rough, peak])


def _power(waves: Values, length: int) -> Values:
    power: Values = np.abs(np.fft.rfft(waves * _fade(waves.shape[1]), length, axis=1)) ** 2
    return power


def _fade(n: int) -> Values:
    """Return weights that fade out the end of a window; the contact is at its start."""
    fade: Values = np.hanning(2 * n + 1)[n : 2 * n]
    return fade


def _level_free(power: Values) -> Values:
    share = power / np.maximum(power.sum(axis=1, keepdims=True), _TINY)
    logs = np.log(share + FLOOR / power.shape[1])
    free: Values = logs - logs.mean(axis=1, keepdims=True)
    return free


@cache
def in_bands(padded: int, rate: float) -> NDArray[np.float64]:
    """Return the weights for the mean of a spectrum's lines in each band, shape (lines, BANDS)."""
    lines = np.fft.rfftfreq(padded, 1.0 / rate)
    edges = np.geomspace(min(LOWEST, rate / 8), rate / 2, BANDS + 1)
    inside = (lines[:, None] >= edges[:-1]) & (lines[:, None] <= edges[1:])
    nearest = np.abs(lines[:, None] - np.sqrt(edges[:-1] * edges[1:])).argmin(axis=0)
    inside[nearest, np.arange(BANDS)] |= ~inside.any(axis=0)
    weights: NDArray[np.float64] = inside / inside.sum(axis=0)
    return weights


#: Kinds of features, the one with the fewest inputs first.
KINDS: Mapping[str, Features] = {
    "bands": log_bands,
    "bands and course": lambda waves, rate: np.concatenate(
        [log_bands(waves, rate), course(waves, rate)], axis=1
    ),
    "lines": log_bins,
}
