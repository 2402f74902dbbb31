"""Synthetic touches: motor lines, then an oscillation that is faster on harder objects."""

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.layout import FINGERTIP_RATE as RATE
from firstcontact.models import Touches
from firstcontact.signal import samples_in

SHORTEST, LONGEST = Touches.lengths(RATE)
LEVELS = (10.0, 20.0, 29.0, 43.0, 60.0)


def ringing(
    n: int, seed: int = 0, gain: float = 1.0, levels: tuple[float, ...] = LEVELS
) -> tuple[Touches, NDArray[np.float64], NDArray[np.str_]]:
    """Return contacts, their Shore A and their sessions. ``gain`` belongs to the sensor."""
    rng = np.random.default_rng(seed)
    lead, tail = samples_in(Touches.BEFORE, RATE), samples_in(Touches.LONGEST, RATE)
    shore_a = np.array([levels[i % len(levels)] for i in range(n)])
    t = np.arange(-lead, tail) / RATE
    signals = np.empty((n, lead + tail))
    for row, hard in enumerate(shore_a):
        speed = np.exp(0.1 * rng.standard_normal())
        motor = sum(
            a * np.sin(2 * np.pi * f * speed * t + rng.uniform(0, 6.28))
            for f, a in ((180, 0.004), (540, 0.002), (1110, 0.002))
        )
        past = np.maximum(t, 0)
        ring = np.sin(2 * np.pi * (40 + 2 * hard) * past) * np.exp(-past / 0.006)
        size = 0.15 * np.exp(hard / 40 + 0.1 * rng.standard_normal()) * speed
        signals[row] = motor + 0.001 * rng.standard_normal(len(t)) + size * ring
    touches = Touches.from_signals(
        (gain * signals).astype(np.float32),
        np.full(n, tail, np.intp),
        rng.integers(0, 2, n).astype(np.intp),
        RATE,
    )
    return touches, shore_a, np.array([f"s{i // len(levels) % 4}" for i in range(n)])
