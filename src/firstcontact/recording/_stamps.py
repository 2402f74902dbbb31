"""Time stamps of a regular stream, split into runs of evenly spaced samples."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError
from firstcontact.recording._lost_samples import lost_samples

#: Shortest gap between stamps, s, and in samples. The jitter of chunks and networks is smaller.
GAP, GAP_SAMPLES = 0.5, 2.5
#: Latest time, s: 300 years, at which a stamp still resolves microseconds.
LATEST = 1e10
#: Largest backward step of stamps, s, from small corrections of a clock.
BACK = 0.05
#: Largest relative difference between measured and stated rate. Crystals differ less.
RATE_SHARE = 0.01
#: Shortest run whose rate is measured, s.
_LONG = 1.0


@dataclass(frozen=True, slots=True)
class Run:
    """Evenly spaced samples ``first`` to ``end`` (exclusive)."""

    first: int
    end: int
    begin: float
    last: float

    @property
    def seconds(self) -> float:
        """Duration up to the end of the last sample, s."""
        return (
            (self.last - self.begin) * (self.end - self.first) / max(self.end - self.first - 1, 1)
        )

    @property
    def rate(self) -> float:
        """Measured rate, Hz."""
        return (self.end - self.first) / self.seconds

    def moments(self, pace: float) -> NDArray[np.float64]:
        """Return times, s, spaced ``1 / pace`` samples, from the first to the last sample."""
        samples = np.arange(math.ceil((self.end - self.first) * pace)) / pace
        # The small shift keeps rounding errors from deciding between two equally near samples.
        moments: NDArray[np.float64] = self.begin + (samples + 1e-3) / self.rate
        return moments

    def between(self, begin: float, end: float) -> Run:
        """Return the samples from the time ``begin`` to the time ``end`` (exclusive), s."""
        skipped = max(0, math.ceil((begin - self.begin) * self.rate))
        dropped = max(0, self.end - self.first - math.ceil((end - self.begin) * self.rate))
        return Run(
            self.first + skipped,
            self.end - dropped,
            self.begin + skipped / self.rate,
            self.last - dropped / self.rate,
        )


def check_stamps(origin: str, stamps: NDArray[np.float64]) -> None:
    """Raise an error for time stamps that cannot be seconds."""
    wrong = np.flatnonzero(~(np.abs(stamps) <= LATEST))
    if len(wrong):
        raise InputError(
            f"{origin} has the time stamp {stamps[wrong[0]]:g} at sample {int(wrong[0])}, which is "
            f"no time within {LATEST:g} s: give stamps in seconds"
        )


def even_runs(origin: str, stamps: NDArray[np.float64], rate: float) -> list[Run]:
    """Return the runs between gaps and lost samples. A line is fitted to the stamps of each run."""
    steps = np.diff(stamps)
    back = np.flatnonzero(steps < -BACK)
    if len(back):
        raise InputError(
            f"{origin} has time stamps that go back by {-steps[back[0]]:.3g} s at sample "
            f"{int(back[0]) + 1}: record it again"
        )
    gap = max(GAP, GAP_SAMPLES / rate)
    runs = []
    for a, b in pairwise([0, *(np.flatnonzero(steps > gap) + 1).tolist(), len(stamps)]):
        losses = [a + k for k in lost_samples(stamps[a:b], rate)]
        if len(losses) * _LONG > (b - a) / rate:
            # Between so many losses, pinches would be too short if much is lost.
            _checked(origin, stamps[a:b], a, rate)
        runs += [
            _checked(origin, stamps[first:end], first, rate)
            for first, end in pairwise([a, *losses, b])
            if end - first > 1
        ]
    return runs


def _checked(origin: str, stamps: NDArray[np.float64], first: int, rate: float) -> Run:
    """Return the run of stamps."""
    run, n = _fitted(stamps, first, rate), len(stamps)
    jitter = rate * float(np.std(stamps - np.linspace(run.begin, run.last, n)))
    if n / rate > _LONG and abs(run.seconds * rate - n) > RATE_SHARE * n + 2 * jitter:
        measured = f"give {run.rate:.5g} Hz" if run.seconds > 0 else "do not advance"
        raise InputError(
            f"{origin} states {rate:g} Hz, but its time stamps {measured}: samples are missing, or "
            "the stated rate is wrong; record it again"
        )
    return run


def _fitted(stamps: NDArray[np.float64], first: int, rate: float) -> Run:
    """Return the run of stamps. A line gives its begin and end, since single stamps jitter."""
    n = len(stamps)
    count = np.arange(n) - (n - 1) / 2
    middle = float(stamps.mean())
    slope = float(count @ (stamps - middle)) / float(count @ count)
    # With few samples the slope is mostly jitter.
    step = slope if n / rate > _LONG else 1.0 / rate
    half = step * (n - 1) / 2
    return Run(first, first + n, middle - half, middle + half)
