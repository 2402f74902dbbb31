"""Checks if a signal is really a vibration: not a clock, and not a copy of another signal."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.physics import GRAVITY

#: Fewest samples of which anything can be said.
FEWEST = 20
#: Largest share of steps of a clock that are backward, as when it wraps, or very long.
ODD = 0.02
#: A step of a clock that is longer than this multiple of the mean step is very long.
LONG = 40.0
#: Largest relative distance of an acceleration at rest from that of gravity.
NEAR_GRAVITY = 0.1
#: Squared correlation above which two signals are one.
ALIKE = 0.99
#: The same for noise, which must then be alike in its differences, too: both fingers of a hand may
#: pick up the same hum.
ALIKE_NOISE = 0.9


def is_clock(values: NDArray[Any]) -> bool:
    """Return True if values rise steadily, as the numbers of a clock or a counter do."""
    if len(values) < FEWEST:
        return False
    steps = np.diff(values.astype(np.float64))
    forward = steps[steps > 0]
    if len(forward) * LONG < len(steps):
        return False
    mean = forward.sum() / len(steps)
    if np.mean((steps < 0) | (steps > LONG * mean)) > ODD:
        return False
    # It rises in each part of the samples by about as much.
    parts = np.array([np.maximum(part, 0.0).sum() for part in np.array_split(steps, 4)])
    return bool(parts.min() > 0.5 * parts.max())


def clock_column_warning(names: Sequence[str], pinches: Sequence[NDArray[Any]]) -> str:
    """Return a warning that names a column that is a clock in all pinches; "" if there is none.

    ``names`` are the names of the columns of each array in ``pinches``, shape (samples, columns).
    """
    for column, name in enumerate(names):
        if pinches and all(is_clock(pinch[:, column]) for pinch in pinches):
            return f"{name} rises steadily, as a clock or a counter does: name the sensor's column"
    return ""


def are_alike(one: NDArray[Any], other: NDArray[Any], *, is_noise: bool = False) -> bool:
    """Return True if two signals are the same, up to an offset, a factor and little noise.

    ``is_noise`` is True for signals at rest. The differences
    between consecutive samples must then correlate, too.
    """
    a, b = one.astype(np.float64), other.astype(np.float64)
    if is_noise:
        return min(_correlation(a, b), _correlation(np.diff(a), np.diff(b))) > ALIKE_NOISE
    return _correlation(a, b) > ALIKE


def gravity_unit_warning(name: str, vectors: NDArray[Any], unit: str) -> str:
    """Return a warning if gravity at rest is 9.81 times too large or too small; otherwise "".

    ``vectors`` are the accelerations of the sensor ``name``, shape (samples, 3), in ``unit``. Only
    accelerations in m/s2 are checked.
    """
    if unit != "m/s2" or vectors.ndim != 2 or vectors.shape[1] != 3:
        return ""
    rest = float(np.linalg.norm(np.median(vectors, axis=0)))
    for stated, true, factor in (("m/s2", "g", 1 / GRAVITY), ("g", "m/s2", GRAVITY)):
        if abs(rest / GRAVITY / factor - 1.0) < NEAR_GRAVITY:
            return (
                f"{name} at rest is {rest:.3g} m/s2, but gravity is 9.81: if the numbers are in "
                f"{true} and not in {stated}, correct the unit"
            )
    return ""


def same_signal_warning(
    names: Sequence[str], signals: NDArray[Any], *, is_noise: bool = False
) -> str:
    """Return a warning that names two equal columns of ``signals``; "" if there are none.

    ``signals`` has the shape (samples, columns). ``is_noise`` is passed to
    :func:`are_alike`.
    """
    for k, j in combinations(range(len(names)), 2):
        if are_alike(signals[:, k], signals[:, j], is_noise=is_noise):
            return (
                f"{names[k]} and {names[j]} are one signal twice, so both fingers seem to touch at "
                "once: use one of them (column 'channel' of a table of events, or #NAME after the "
                "name of a board or stream), or check the wiring"
            )
    return ""


def _correlation(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Return the squared correlation of two signals, 0 to 1.

    Return 0 if a signal is constant, or if the signals have fewer than ``FEWEST`` samples.
    """
    if len(a) < FEWEST:
        return 0.0
    a, b = a - a.mean(), b - b.mean()
    power = float((a * a).sum() * (b * b).sum())
    return float((a * b).sum()) ** 2 / power if power > 0 else 0.0
