"""Splitting of a stream's time stamps into runs of evenly spaced samples."""

from __future__ import annotations

import math
from bisect import bisect
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FileError

#: Shortest gap between stamps, s, and in samples. The jitter of chunks and networks is smaller.
GAP, GAP_SAMPLES = 0.5, 2.5
#: Largest backward step of stamps, s, from small corrections of a clock.
BACK = 0.05
#: Largest relative difference between measured and stated rate. Crystals differ less.
RATE_SHARE = 0.01
#: Shortest run whose rate is measured, s.
_LONG = 1.0
#: Largest distance of a run from the samples of another stream, in samples of that stream.
_FARTHEST = 1.5
#: Stamps are regular if no step is too short by this many samples or more, and more than this share
#: of the steps is off by less.
_STEADY, _MOST = 0.25, 0.7
#: Jittering stamps are compared as medians of blocks of this length, s.
_BLOCK = 0.2
#: Largest and smallest number of blocks that are compared on each side of a loss.
_LARGEST, _FEWEST = 25, 8
#: Number of blocks on each side that may be off, because of delays.
_OUTLIERS = 2
#: Numbers of blocks between two whose difference gives the rate. Several numbers, because blocks of
#: a sender beat with our blocks.
_LAGS = range(5, 15)
#: Smallest loss that is detected in jittering stamps, s, and in samples.
_SMALLEST, _SMALLEST_SAMPLES = 0.001, 2.0

Values = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Run:
    """Evenly spaced samples of a stream without a gap.

    They have the numbers ``first`` to ``end`` (exclusive). ``begin`` and ``last`` are the times of
    the first and the last one, s.
    """

    first: int
    end: int
    begin: float
    last: float

    @property
    def seconds(self) -> float:
        """Duration of the run, to the end of the last sample, s."""
        count = self.end - self.first
        return (self.last - self.begin) * count / max(count - 1, 1)

    @property
    def rate(self) -> float:
        return (self.end - self.first) / self.seconds

    def times(self, pace: float) -> Values:
        """Return evenly spaced times over this run, s, ``pace`` times per sample."""
        samples = np.arange(math.ceil((self.end - self.first) * pace)) / pace
        # The small shift keeps rounding errors from deciding between two equally near samples.
        times: Values = self.begin + (samples + 1e-3) / self.rate
        return times

    def between(self, begin: float, end: float) -> Run:
        """Return the part of this run from the time ``begin`` to ``end`` (exclusive), s."""
        skipped = max(0, math.ceil((begin - self.begin) * self.rate))
        dropped = max(0, self.end - self.first - math.ceil((end - self.begin) * self.rate))
        return Run(
            self.first + skipped,
            self.end - dropped,
            self.begin + skipped / self.rate,
            self.last - dropped / self.rate,
        )


def even_runs(origin: str, stamps: Values, rate: float) -> list[Run]:
    """Split a stream at gaps. Return a run of evenly spaced samples for each piece.

    ``stamps`` are the time stamps of the samples, s, and ``rate`` is the stated rate, Hz. Raises
    FileError, with the name ``origin``, if the stamps go back or contradict the rate.
    """
    steps = np.diff(stamps)
    back = np.flatnonzero(steps < -BACK)
    if len(back):
        raise FileError(
            f"{origin} has time stamps that go back by {-steps[back[0]]:.3g} s at sample "
            f"{int(back[0]) + 1}: record it again"
        )
    gap = max(GAP, GAP_SAMPLES / rate)
    runs = []
    for a, b in pairwise([0, *(np.flatnonzero(steps > gap) + 1).tolist(), len(stamps)]):
        losses = [a + k for k in lost_samples(stamps[a:b], rate)]
        if len(losses) * _LONG > (b - a) / rate:
            # Between so many losses, pinches would be too short if much is lost.
            _fit_run(origin, stamps[a:b], a, rate)
        runs += [
            _fit_run(origin, stamps[first:end], first, rate)
            for first, end in pairwise([a, *losses, b])
            if end - first > 1
        ]
    return runs


def _fit_run(origin: str, stamps: Values, first: int, rate: float) -> Run:
    """Fit evenly spaced times to the time stamps of a piece, because single stamps jitter.

    ``first`` is the number of the first sample. Raises FileError if a long piece shows that the
    stated ``rate``, Hz, is wrong.
    """
    n = len(stamps)
    count = np.arange(n) - (n - 1) / 2
    middle = float(stamps.mean())
    is_long = n / rate > _LONG
    # With few samples the slope is mostly jitter.
    step = float(count @ (stamps - middle)) / float(count @ count) if is_long else 1.0 / rate
    half = step * (n - 1) / 2
    run = Run(first, first + n, middle - half, middle + half)
    jitter = rate * float(np.std(stamps - np.linspace(run.begin, run.last, n)))
    if is_long and abs(run.seconds * rate - n) > RATE_SHARE * n + 2 * jitter:
        measured = f"give {run.rate:.5g} Hz" if run.seconds > 0 else "do not advance"
        raise FileError(
            f"{origin} states {rate:g} Hz, but its time stamps {measured}: samples are missing, or "
            "the stated rate is wrong; if so, give the measured one as 'rate_hz' with --channels"
        )
    return run


def overlaps(runs: Sequence[Run], others: Sequence[Run]) -> list[Run]:
    """Return the parts of ``runs`` during which the stream of ``others`` has samples, too."""
    spans: list[tuple[float, float]] = []
    for run in others:
        margin = _FARTHEST / run.rate
        begin, end = run.begin - margin, run.begin + run.seconds + margin
        if spans and begin <= spans[-1][1]:
            begin, end = spans[-1][0], max(end, spans.pop()[1])
        spans.append((begin, end))
    ends = [end for _, end in spans]
    parts = [
        run.between(begin, end)
        for run in runs
        for begin, end in spans[bisect(ends, run.begin) : bisect(spans, (run.last,))]
    ]
    return [part for part in parts if part.end - part.first > 1]


class Nearest:
    """Lookup of the stream's sample that is nearest to a time."""

    def __init__(self, runs: Sequence[Run]) -> None:
        times = np.concatenate([np.linspace(r.begin, r.last, r.end - r.first) for r in runs])
        self._borders = (times[1:] + times[:-1]) / 2
        self._numbers = np.concatenate([np.arange(r.first, r.end) for r in runs])

    def samples(self, times: Values) -> NDArray[np.int64]:
        """Return the number of the sample that is nearest to each time, s."""
        numbers: NDArray[np.int64] = self._numbers[np.searchsorted(self._borders, times)]
        return numbers


def lost_samples(stamps: Values, rate: float) -> list[int]:
    """Return the indices of the samples before which samples were lost, from time stamps in s."""
    errors = np.diff(stamps) * rate - 1.0  # of the steps, in samples
    if len(errors) and errors.min() > -_STEADY and np.mean(errors < _STEADY) > _MOST:
        after_loss: list[int] = (np.flatnonzero(errors > 1 - _STEADY) + 1).tolist()
        return after_loss
    size = math.ceil(_BLOCK * rate)
    n = len(stamps) // size
    levels = np.median(stamps[: n * size].reshape(n, size), axis=1)
    places, stretches = [], [(0, n)]
    while stretches:
        first, end = stretches.pop()
        if end - first < 2 * _FEWEST:
            continue
        pace = _typical_rise(levels[first:end])
        lateness = levels[first:end] - pace * np.arange(first, end)
        rises, falls = (_jumps(x)[_FEWEST:-_FEWEST] for x in (lateness, -lateness))
        k = int(np.argmax(rises))
        # Delays end: they have falls as large as their rises.
        if rises[k] < max(_SMALLEST, _SMALLEST_SAMPLES / rate, 1.5 * falls.max()):
            continue
        k += _FEWEST
        # Of all places near k, two levels explain the stamps best with a change at this one.
        early = np.median(lateness[max(0, k - _LARGEST) : k])
        late = np.median(lateness[k : k + _LARGEST])
        near = (first + k) * size + np.arange(-(_OUTLIERS + 1) * size, (_OUTLIERS + 1) * size)
        each = stamps[near] - pace * (near - (size - 1) / 2) / size
        misfit = np.cumsum(np.abs(each - early) - np.abs(each - late))
        place = int(near[np.argmin(misfit)]) + 1
        places.append(place)
        stretches += [(first, round(place / size)), (round(place / size), end)]
    return sorted(places)


def _typical_rise(levels: Values) -> float:
    """Return the median rise of the time stamps from one block to the next, s.

    ``levels`` are the median time stamps of consecutive blocks.
    """
    rises = [(levels[lag:] - levels[:-lag]) / lag for lag in _LAGS]
    return float(np.median(np.concatenate(rises)))


def _jumps(levels: Values) -> Values:
    """Return the jump of the time stamps before each block, s, shape (blocks + 1,).

    ``levels`` are the median time stamps of consecutive blocks. A jump is the least stamp of the
    blocks after it minus the largest stamp of the blocks before it, both without outliers.
    """
    padding = np.full(_LARGEST, np.inf)
    padded = [np.concatenate([levels, padding]), np.concatenate([padding, -levels])]
    windows = np.lib.stride_tricks.sliding_window_view(padded, _LARGEST, axis=1)
    lowest, highest = np.partition(windows, _OUTLIERS, axis=2)[:, :, _OUTLIERS]
    rises: Values = lowest + highest
    return rises
