"""Time stamps of a regular stream into runs of evenly spaced samples."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError

#: Two stamps further apart than this are a gap, s: chunks and networks jitter less.
GAP = 0.5
#: Latest time, s: 300 years, where a stamp still tells microseconds apart.
LATEST = 1e10
#: Stamps may go back by less than this, s: clocks are corrected a little now and then.
BACK = 0.05
#: The rate of a run may differ from the stated one by this share: crystals differ less.
RATE_SHARE = 0.01
#: Shortest run whose rate is measured, s.
_LONG = 1.0


@dataclass(frozen=True, slots=True)
class Run:
    """Samples ``first`` to ``end`` (one past the last), evenly from ``begin`` to ``last``, s."""

    first: int
    end: int
    begin: float
    last: float

    @property
    def seconds(self) -> float:
        """How long it lasts, to the end of its last sample."""
        return (
            (self.last - self.begin) * (self.end - self.first) / max(self.end - self.first - 1, 1)
        )

    @property
    def rate(self) -> float:
        """As measured, Hz."""
        return (self.end - self.first) / self.seconds

    def covers(self, other: Run) -> bool:
        """Whether it overlaps another and begins before it, give or take one of its samples."""
        return self.begin <= other.begin + 1.5 / self.rate and self.last > other.begin


def check_stamps(where: str, stamps: NDArray[np.float64]) -> None:
    """Refuse time stamps that cannot be seconds.

    Parameters
    ----------
    where
        Named in messages.
    stamps
        s, shape (samples,).

    Raises
    ------
    InputError
        A stamp is not a number, or beyond ``LATEST``.
    """
    wrong = np.flatnonzero(~(np.abs(stamps) <= LATEST))
    if len(wrong):
        raise InputError(
            f"{where} has the time stamp {stamps[wrong[0]]:g} at sample {int(wrong[0])}, which is "
            f"no time within {LATEST:g} s: give stamps in seconds"
        )


def even_runs(where: str, stamps: NDArray[np.float64], rate: float) -> list[Run]:
    """Runs between gaps; a line through the stamps of each says when its samples were taken.

    Parameters
    ----------
    where
        That messages name.
    stamps
        s, shape (samples,), as :func:`check_stamps` takes them.
    rate
        That is said of them, Hz.

    Raises
    ------
    InputError
        Stamps go back, or a run's rate is another than said.
    """
    steps = np.diff(stamps)
    back = np.flatnonzero(steps < -BACK)
    if len(back):
        raise InputError(
            f"{where} has time stamps that go back by {-steps[back[0]]:.3g} s at sample "
            f"{int(back[0]) + 1}: record it again"
        )
    runs = []
    for a, b in pairwise([0, *(np.flatnonzero(steps > GAP) + 1).tolist(), len(stamps)]):
        if b - a < 2:
            continue
        run = _fitted(stamps[a:b], a, rate)
        if (b - a) / rate > _LONG and abs(run.seconds * rate - (b - a)) > RATE_SHARE * (b - a):
            measured = f"{run.rate:.5g} Hz" if run.seconds > 0 else "do not advance"
            raise InputError(
                f"{where} says {rate:g} Hz and its time stamps {measured}: samples are "
                "missing, or the stated rate is wrong; record it again"
            )
        runs.append(run)
    return runs


def _fitted(stamps: NDArray[np.float64], first: int, rate: float) -> Run:
    """Its begin and last by a line, since each stamp by itself jitters."""
    n = len(stamps)
    count = np.arange(n) - (n - 1) / 2
    middle = float(stamps.mean())
    slope = float(count @ (stamps - middle)) / float(count @ count)
    # Of few samples the slope is mostly jitter.
    step = slope if n / rate > _LONG else 1.0 / rate
    half = step * (n - 1) / 2
    return Run(first, first + n, middle - half, middle + half)
