"""To another sampling rate as samples come: the filter of :func:`resample`, with its state."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from firstcontact.signal._resample import _low_pass, _ratio


class CausalResampler:
    """Gives what :func:`firstcontact.signal.resample` gives, block by block.

    Sample ``k`` that comes out stands for the instant at which sample ``k * old / new`` came in.
    What is missing is not made up: behind a gap it begins anew, as with a first sample that has
    always been there.

    Parameters
    ----------
    old, new
        Rates, Hz.
    nearest
        Columns whose samples take the value of the nearest one: switches are open or closed.

    Attributes
    ----------
    delay
        So long after its instant a sample comes out, s; 0.5 ms at most.
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
        # Of each place between two samples its taps, the oldest sample's first.
        self._taps = np.ascontiguousarray(padded.reshape(length, self._up).T[:, ::-1])
        self._past: NDArray[np.float64] | None = None
        self._end = 0  # number of the next sample that comes in
        self._next = 0  # of the next one that comes out

    def number(self, sample: int) -> int:
        """Return the number of the sample that comes out nearest to one that comes in."""
        return (2 * sample * self._up + self._down) // (2 * self._down)

    def update(self, x: NDArray[np.floating], first: int) -> tuple[NDArray[np.float64], int]:
        """Take the next samples.

        Parameters
        ----------
        x
            Shape (samples, channels).
        first
            Number of the first of them, not before the end of what came last.

        Returns
        -------
        tuple
            What comes out by them, shape (samples, channels), and the number of its first.
        """
        if not len(x):
            return np.zeros(x.shape), self._next
        before = self._taps.shape[1] - 1
        if self._past is None or first != self._end:
            self._past = np.repeat(np.asarray(x[:1], np.float64), before, axis=0)
            # The first whose instant is not before this sample.
            self._next = -(-first * self._up // self._down)
        held = np.concatenate([self._past, x])
        origin = first - before  # number of held[0]
        self._end = first + len(x)
        # Sample k needs those up to (k down + ahead) / up, which is below the end for these.
        stop = max(-(-(self._end * self._up - self._ahead) // self._down), self._next)
        places = np.arange(self._next, stop) * self._down + self._ahead
        newest, phases = places // self._up, places % self._up
        rows = (newest - before - origin)[:, None] + np.arange(before + 1)
        out = np.einsum("kt,ktc->kc", self._taps[phases], held[rows])
        if self._nearest:
            # Numbers of the samples that came in nearest to these instants.
            centres = 2 * np.arange(self._next, stop) * self._down
            here = np.minimum((centres + self._up) // (2 * self._up), self._end - 1) - origin
            out[:, self._nearest] = held[here][:, self._nearest]
        self._past = held[len(held) - before :] if before else held[:0]
        began, self._next = self._next, stop
        return out, began
