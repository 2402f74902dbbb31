"""Pinches that begin at rest, before the motor starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from firstcontact.core import ChannelKind, Dataset, Pinch
from firstcontact.signal import ExponentialSmoothing

#: RMS of electronics and amplitude of hum of the twin, V.
ELECTRONICS, HUM = 0.0022, 0.0015


def rested(
    dataset: Dataset,
    rest_range: tuple[float, float] = (0.05, 0.4),
    electronics: float = ELECTRONICS,
    jerk: float = 0.03,
    seed: int = 0,
) -> Dataset:
    """Return the pinches with some seconds of rest before them.

    During rest there are only noise and hum of the electronics, because the motor does not run.

    The motor starts with a jerk of ``jerk`` V, and reaches its full loudness within 20 ms.
    """
    rng = np.random.default_rng(seed)
    return replace(
        dataset,
        pinches=tuple(
            _prepend_quiet(
                p, round(rng.uniform(*rest_range) * p.layout.rate), electronics, jerk, rng
            )
            for p in dataset.pinches
        ),
    )


def _prepend_quiet(
    pinch: Pinch, n: int, electronics: float, jerk: float, rng: np.random.Generator
) -> Pinch:
    layout, rate = pinch.layout, pinch.layout.rate
    motor = pinch.data.astype(np.float64)
    prefix = np.repeat(motor[:1], n, axis=0)
    growing = round(0.02 * rate)
    ramp = np.linspace(0.0, 1.0, growing)
    t = np.arange(len(motor)) / rate
    for column in layout.columns(ChannelKind.VIBRATION):
        volt, zero = 1.0 / layout.channels[column].scale, layout.channels[column].offset
        white = electronics * rng.standard_normal((n + growing, 1))
        hum = HUM * np.sin(2 * np.pi * 50 * np.arange(n + growing) / rate + rng.uniform(0, 6))
        noise = ExponentialSmoothing(0.5).update(white)[:, 0] + hum * (electronics > 0)
        prefix[:, column] = zero + volt * noise[:n]
        start = ramp * (motor[:growing, column] - zero) + volt * (1 - ramp) * noise[n:]
        motor[:growing, column] = zero + start
        sign = rng.choice([-1.0, 1.0])
        motor[:, column] += sign * volt * jerk * np.exp(-t / 0.004) * np.sin(2 * np.pi * 180 * t)
    data = np.concatenate([prefix, motor])
    if pinch.data.dtype.kind == "i":
        data = np.rint(data.clip(0, 32736))
    truth = tuple(replace(c, sample=c.sample + n, decided=c.decided + n) for c in pinch.truth)
    return replace(pinch, data=data.astype(pinch.data.dtype), truth=truth)
