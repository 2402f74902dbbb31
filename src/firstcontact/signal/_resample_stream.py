"""Resampling of a stream, with the filter of :func:`resample`, block by block."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from firstcontact.signal._resample import _low_pass, _ratio


class CausalResampler:
    """Resampler of a stream. It gives the same samples as :func:`firstcontact.signal.resample`.

    Output sample ``k`` belongs to the time of input sample ``k * old / new``. Missing samples are
    not filled in. After a gap the filter restarts as if the signal before had been constant.

    Parameters
    ----------
    old, new
        Rates, Hz.
    nearest
        Columns that take the value of the nearest sample, such as strips.

    Attributes
    ----------
    delay
        Delay of the output: time from the instant of an output sample until the sample is
        available, s; at most 0.5 ms.
    """

    def __init__(self, old: float, new: float, nearest: Sequence[int] = ()) -> None:
        ratio = _ratio(old, new)
        self._nearest = list(nearest)
        self._up, self._down = ratio.numerator, ratio.denominator
        taps, self._ahead = _low_pass(ratio, old)
        self.delay = self._ahead / (self._up * old)
        length = -(-len(taps) // self._up)
        padded = np.zeros(length * self._up)
        padded[: len(taps)] = taps * self._up
        # One row of taps per position between two input samples, oldest sample first.
        self._taps = np.ascontiguousarray(padded.reshape(length, self._up).T[:, ::-1])
        self._past: NDArray[np.float64] | None = None
        self._end = 0  # number of the next input sample
        self._next = 0  # number of the next output sample

    def number(self, sample: int) -> int:
        """Return the number of the output sample nearest to an input sample."""
        return (2 * sample * self._up + self._down) // (2 * self._down)

    def update(self, x: NDArray[np.floating], first: int) -> tuple[NDArray[np.float64], int]:
        """Resample the next samples.

        Parameters
        ----------
        x
            Shape (samples, channels).
        first
            Number of the first input sample, not before the end of the previous input.

        Returns
        -------
        tuple
            Output samples, shape (samples, channels), and the number of the first output sample.
        """
        if not len(x):
            return np.zeros(x.shape), self._next
        history = self._taps.shape[1] - 1
        if self._past is None or first != self._end:
            self._past = np.repeat(np.asarray(x[:1], np.float64), history, axis=0)
            # First output whose instant is not before this sample.
            self._next = -(-first * self._up // self._down)
        samples = np.concatenate([self._past, x])
        origin = first - history  # number of samples[0]
        self._end = first + len(x)
        # Output k needs inputs up to (k down + ahead) / up, which must be below the end.
        stop = max(-(-(self._end * self._up - self._ahead) // self._down), self._next)
        places = np.arange(self._next, stop) * self._down + self._ahead
        newest, phases = places // self._up, places % self._up
        rows = (newest - history - origin)[:, None] + np.arange(history + 1)
        out = np.einsum("kt,ktc->kc", self._taps[phases], samples[rows])
        if self._nearest:
            # Numbers of the input samples nearest to these instants.
            centres = 2 * np.arange(self._next, stop) * self._down
            nearest = np.minimum((centres + self._up) // (2 * self._up), self._end - 1) - origin
            out[:, self._nearest] = samples[nearest][:, self._nearest]
        self._past = samples[len(samples) - history :] if history else samples[:0]
        first_output, self._next = self._next, stop
        return out, first_output
