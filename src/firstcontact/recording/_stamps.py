"""Time stamps of a regular stream, split into runs of evenly spaced samples."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError

#: Shortest gap between stamps, s. The jitter of chunks and networks is smaller.
GAP = 0.5
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
    """Evenly spaced samples ``first`` to ``end`` (exclusive).

    ``begin`` and ``last`` are the times of the first and of the last sample, s.
    """

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

    def covers(self, other: Run) -> bool:
        """Return True if this run overlaps ``other`` and begins at most 1.5 samples after it."""
        return self.begin <= other.begin + 1.5 / self.rate and self.last > other.begin


def check_stamps(origin: str, stamps: NDArray[np.float64]) -> None:
    """Raise an error for time stamps that cannot be seconds.

    Parameters
    ----------
    origin
        Name of the stream, for messages.
    stamps
        Time stamps, s, shape (samples,).

    Raises
    ------
    InputError
        A stamp is not a number, or beyond ``LATEST``.
    """
    wrong = np.flatnonzero(~(np.abs(stamps) <= LATEST))
    if len(wrong):
        raise InputError(
            f"{origin} has the time stamp {stamps[wrong[0]]:g} at sample {int(wrong[0])}, which is "
            f"no time within {LATEST:g} s: give stamps in seconds"
        )


def even_runs(origin: str, stamps: NDArray[np.float64], rate: float) -> list[Run]:
    """Return the runs between the gaps of time stamps. A line is fitted to the stamps of each run.

    Parameters
    ----------
    origin
        Name of the stream, for messages.
    stamps
        Time stamps, s, shape (samples,), accepted by :func:`check_stamps`.
    rate
        Stated rate, Hz.

    Raises
    ------
    InputError
        Stamps go back, or the rate of a run differs from the stated rate.
    """
    steps = np.diff(stamps)
    back = np.flatnonzero(steps < -BACK)
    if len(back):
        raise InputError(
            f"{origin} has time stamps that go back by {-steps[back[0]]:.3g} s at sample "
            f"{int(back[0]) + 1}: record it again"
        )
    runs = []
    for a, b in pairwise([0, *(np.flatnonzero(steps > GAP) + 1).tolist(), len(stamps)]):
        if b - a < 2:
            continue
        run = _fitted(stamps[a:b], a, rate)
        if (b - a) / rate > _LONG and abs(run.seconds * rate - (b - a)) > RATE_SHARE * (b - a):
            measured = f"give {run.rate:.5g} Hz" if run.seconds > 0 else "do not advance"
            raise InputError(
                f"{origin} states {rate:g} Hz, but its time stamps {measured}: samples are "
                "missing, or the stated rate is wrong; record it again"
            )
        runs.append(run)
    return runs


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
