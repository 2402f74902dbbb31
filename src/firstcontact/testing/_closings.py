"""Synthetic closings with known contacts: noise, hum, clicks and damped oscillations."""

from __future__ import annotations

import numpy as np

from firstcontact.core import Contact, Dataset, Finger, Label, Pinch, fingertip_layout
from firstcontact.signal import ExponentialSmoothing

LAYOUT = fingertip_layout()
SAMPLES = 1200


def closing(seed: int, *, touches: bool = True, session: str = "") -> Pinch:
    rng = np.random.default_rng(seed)
    counts = np.zeros((SAMPLES, 16))
    first = int(rng.integers(450, 700))
    second = first + int(rng.integers(30, 150))
    finger = Finger(int(rng.integers(2)))
    t = np.arange(SAMPLES)
    for f, touched in ((finger, first), (finger.other, second)):
        x = rng.normal(0, 3, SAMPLES) + 4 * np.sin(0.3 * t + 6 * rng.random())
        x[rng.integers(0, SAMPLES, 2)] += rng.normal(0, 30, 2)
        if touches:
            age = t[touched:] - touched
            x[touched:] += rng.uniform(150, 400) * np.exp(-age / 20) * np.sin(0.25 * age + 0.3)
        counts[:, f] = ExponentialSmoothing(0.5).update(x[:, None])[:, 0]
    data = np.rint(np.clip(512 + counts, 0, 1023) * 32).astype(np.int16)
    start = 10_000 * (seed + 1)
    truth = tuple(
        Contact(f, start + s, start + s) for f, s in ((finger, first), (finger.other, second))
    )
    return Pinch(data, LAYOUT, Label(session=session), start, truth if touches else ())


def closings(n: int, seed: int = 0, sessions: int = 4) -> Dataset:
    """Return ``n`` synthetic closings, assigned to ``sessions`` sessions in rotation."""
    return Dataset(
        tuple(closing(1000 * seed + i, session=f"s{i % sessions}") for i in range(n)), "synthetic"
    )
