"""Synthetic windows of a contact: damped oscillations, faster and louder on harder objects."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.layout import FINGERTIP_RATE

RATE = FINGERTIP_RATE
LEVELS = (10.0, 29.0, 60.0)


def toy_windows(
    n: int = 180, samples: int = 74, channels: int = 1, seed: int = 0
) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.str_]]:
    """Return windows, and the Shore A and session of each. Each session has its own gain."""
    rng = np.random.default_rng(seed)
    shore = rng.choice(LEVELS, n)
    session = rng.integers(0, 6, n)
    hard = shore + rng.normal(0, 1.0, n)
    gain = np.exp(rng.normal(0, 0.1, 6))[session] * np.exp(rng.normal(0, 0.1, n))
    t = np.arange(samples) / RATE
    rise = np.sin(2 * np.pi * (60 * np.exp(hard / 35))[:, None] * t)
    fall = np.exp(-t / (0.010 * np.exp(-hard / 60))[:, None])
    volts = (0.02 * hard * gain)[:, None] * fall * rise
    X = np.stack([volts] * channels, axis=2) + rng.normal(0, 0.01, (n, samples, channels))
    return X.astype(np.float32), shore, session.astype(np.str_)
