"""Specification of window models: task, rate, shape of windows, and classes."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError, is_same_rate

Arrays = dict[str, NDArray[Any]]
Windows = NDArray[np.float32]
Values = NDArray[np.float64]


class Task(StrEnum):
    """Learning task of an estimator."""

    REGRESSION = "regression"
    CLASSIFICATION = "classification"


@dataclass(frozen=True, slots=True)
class Spec:
    """Specification of a window model.

    Parameters
    ----------
    task
        Task. Regression predicts any real number, classification one of ``classes``.
    rate
        Sampling rate of the windows, Hz.
    samples, channels
        Shape of one window.
    classes
        Values of the classes in ascending order; empty for regression.

    Examples
    --------
    >>> spec = Spec(Task.REGRESSION, rate=4936.0, samples=74)
    >>> round(1e3 * spec.duration)
    15
    """

    task: Task
    rate: float
    samples: int
    channels: int = 1
    classes: tuple[float, ...] = ()

    @property
    def duration(self) -> float:
        """Length of the window, s."""
        return self.samples / self.rate

    def require_rate(self, rate: float) -> None:
        """Refuse windows of another sampling rate.

        Raises
        ------
        InputError
            The rate (Hz) differs by more than 1 %.
        """
        if not is_same_rate(rate, self.rate):
            raise InputError(
                f"the model takes windows at {self.rate:g} Hz but these have {rate:g} Hz: train a "
                f"model for this rate with `firstcontact train --rate {rate:g}`"
            )

    def check_one(self, window: NDArray[Any]) -> None:
        """Refuse a window that the model cannot use.

        Raises
        ------
        InputError
            The shape is not (samples, channels), a value is not finite, or a channel is constant
            (an unplugged sensor).
        """
        if window.shape != (self.samples, self.channels):
            raise InputError(
                f"the model takes windows of {self.samples} samples and {self.channels} "
                f"channel(s), shape ({self.samples}, {self.channels}), not {window.shape}: "
                f"cut {1e3 * self.duration:.3g} ms at {self.rate:g} Hz"
            )
        for channel in window.T:
            # NaN fails both comparisons, an infinity the second one.
            if not 0.0 < np.maximum.reduce(channel) - np.minimum.reduce(channel) < np.inf:
                raise InputError(
                    "the window is constant or has values that are not finite: "
                    "check the sensor's plug and leave this pinch out"
                )

    def check(self, X: NDArray[Any]) -> None:
        """Refuse windows, shape (n, samples, channels), as :meth:`check_one` does.

        Raises
        ------
        InputError
            A window cannot be used. The message names the first such window.
        """
        if X.ndim != 3 or X.shape[1:] != (self.samples, self.channels):
            raise InputError(
                f"the model takes windows of shape (n, {self.samples}, {self.channels}), "
                f"not {X.shape}: cut {1e3 * self.duration:.3g} ms at {self.rate:g} Hz"
            )
        bad = np.flatnonzero(~usable(X))
        if len(bad):
            raise InputError(
                f"window {bad[0]} ({len(bad)} in all) is constant or has values that are not "
                "finite: check the sensor's plug and leave these pinches out"
            )


def usable(X: NDArray[Any]) -> NDArray[np.bool_]:
    """Return a mask of windows (n, samples, channels) that are finite and vary, shape (n,)."""
    if X.shape[1] == 0:
        return np.zeros(len(X), dtype=np.bool_)
    with np.errstate(invalid="ignore", over="ignore"):
        span = X.max(axis=1) - X.min(axis=1)
    good: NDArray[np.bool_] = ((span > 0) & (span < np.inf)).all(axis=1)
    return good
