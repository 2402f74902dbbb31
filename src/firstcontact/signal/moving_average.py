"""Sliding-window mean, as the microcontroller does it to the force channels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.layout import FINGERTIP_RATE


class MovingAverage:
    """Mean of the newest ``length`` samples.

    Before ``length`` samples have come the first one stands in for those
    missing, so a constant comes out unchanged.

    Parameters
    ----------
    length
        Samples in the mean, at least 1.
    rate
        Sampling rate, Hz; only :attr:`latency` uses it.

    Raises
    ------
    ValueError
        When ``length`` is below 1.
    """

    def __init__(self, length: int, rate: float = FINGERTIP_RATE) -> None:
        if length < 1:
            raise ValueError(f"length is {length}; it must be at least 1")
        self.length = length
        self.rate = rate
        self._past: NDArray[np.float64] | None = None

    @property
    def latency(self) -> float:
        """Group delay, s: ``(length - 1) / 2`` samples."""
        return (self.length - 1) / 2.0 / self.rate

    def reset(self) -> None:
        """Forget the past."""
        self._past = None

    def update(self, x: NDArray[Any]) -> NDArray[np.float64]:
        """Filter the next samples.

        Parameters
        ----------
        x
            Shape (n, channels).

        Returns
        -------
        ndarray
            Shape (n, channels); the same numbers whatever the blocks.
        """
        samples = np.asarray(x, dtype=np.float64)
        n = len(samples)
        if n == 0:
            return samples.copy()
        if self._past is None:
            self._past = np.repeat(samples[:1], self.length - 1, axis=0)
        joined = np.concatenate([self._past, samples])
        # Summed afresh for each output: a running sum would drift, and would
        # round differently for every split into blocks.
        total = np.zeros_like(samples)
        for k in range(self.length):
            total += joined[k : k + n]
        self._past = joined[n:].copy()
        out: NDArray[np.float64] = total / self.length
        return out
