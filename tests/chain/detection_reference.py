"""Readable reference of the chain's detection: gate, steady state, detectors, onset, confirmation.

It works on whole stretches of samples, with NumPy.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import log

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from firstcontact.chain import EventKind, Flag, Reason
from firstcontact.chain.constants import DetectorConstants, DetectorKind
from firstcontact.signal import samples_in

Array = NDArray[np.float64]
#: Kind, reason, flags, channel, sample, and last sample that the event depends on.
Event = tuple[int, int, int, int, int, int]
#: Number of steps over which the gate judges.
STEPS = 13
ORDER = 12


@dataclass(frozen=True)
class Stream:
    """Sensors, and the chain's parameters.

    Parameters
    ----------
    alpha
        Coefficient of the smoothing of each vibration channel.
    floors
        Noise of each vibration channel at rest, V; None if unknown.
    after
        Time from the first contact to the end of a closing, s.
    """

    rate: float
    constants: DetectorConstants
    alpha: Array
    floors: Array | None
    is_by_hand: bool = False
    keeps_first_state: bool = False
    after: float = 0.2

    def samples(self, duration: float) -> int:
        return max(1, samples_in(duration, self.rate))


@dataclass
class Stretch:
    """Samples without a gap: vibration in V, and voltages of the taxels, shape (n, channels)."""

    first: int
    epoch: int
    vibration: Array
    loads: Array

    @property
    def end(self) -> int:
        return self.first + len(self.vibration)


# Gate


@dataclass
class Gate:
    """Gate that opens when the motor has run for 13 steps without a load, and shuts at rest.

    If a person moves the sensor, it opens at rest.
    """

    stream: Stream
    state: str = "lost"
    is_open: bool = False
    steps: int = 0
    since: int = 0
    held: int = -STEPS
    due: int | None = None
    unloaded: Array | None = None

    def step(self, quiet: bool, level: Array, end: int) -> tuple[bool, bool]:
        """Process a step, which ends before sample ``end``. Return True if it shuts and opens.

        ``level`` is the mean voltage of each taxel.
        """
        may_open = self.due is None or end >= self.due
        shuts = opens = False
        if self.state in ("lost", "open"):
            if quiet and may_open and self.steps - self.since >= STEPS:
                self._go("rest")
                opens = self.stream.is_by_hand
                shuts = self.is_open
        elif quiet:
            if self.state == "starting":
                self._go("rest")
            self.unloaded = level if self.unloaded is None else np.fmin(self.unloaded, level)
            opens = self.due is not None and may_open
            shuts = opens and self.is_open
        elif self.state == "rest":
            self._go("starting")
            self.since -= STEPS // 2
        else:
            if self.unloaded is not None and (level > self.unloaded + 0.3).any():
                self.held = self.steps
            if may_open and self.steps - max(self.since, self.held) >= STEPS:
                self._go("open")
                opens, shuts = True, self.is_open
        if opens:
            self.due = None
        self.is_open = opens or (self.is_open and not shuts)
        self.steps += 1
        return shuts, opens

    def _go(self, state: str) -> None:
        self.state, self.since = state, self.steps


def quiet_steps(volts: Array, floors: Array) -> list[bool]:
    """Return True for each step, shape (samples, channels), at which the motor rests.

    The median power of the newest 13 steps, around the median of their means, is then low.
    """
    quiet = [False] * min(STEPS - 1, len(volts))
    if len(volts) >= STEPS:
        means = sliding_window_view(volts.mean(axis=1), STEPS, axis=0)
        squares = sliding_window_view((volts**2).mean(axis=1), STEPS, axis=0)
        mean = median(means)[..., None]
        power = median(squares - 2 * mean * means + mean**2)
        is_quiet = np.all(power <= (1.4 * floors) ** 2, axis=1)
        quiet += np.asarray(is_quiet).tolist()
    return quiet


def median(x: Array) -> Array:
    """Return the median along the last axis. NaN counts as the largest number."""
    out: Array = np.sort(x)[..., x.shape[-1] // 2]
    return out


# Detectors


def measure(quiet: Array) -> tuple[Array, Array]:
    """Return mean and sigma of each channel; the sigma of a constant channel is 0."""
    varies = (quiet != quiet[0]).any(axis=0)
    return quiet.mean(axis=0), np.where(varies, quiet.std(axis=0), 0.0)


def prediction(quiet: Array) -> Array:
    """Return weights that remove the predictable part of one channel's noise (Yule-Walker)."""
    n = len(quiet)
    lags = np.array([quiet[: n - k] @ quiet[k:] for k in range(ORDER + 1)]) / n
    lags[0] *= 1.001
    matrix = lags[np.abs(np.subtract.outer(np.arange(ORDER), np.arange(ORDER)))]
    weights = np.append(1.0, -np.linalg.solve(matrix, lags[1:]))
    return np.asarray(weights / prediction_error(quiet, weights).std())


def prediction_error(x: Array, weights: Array) -> Array:
    """Return the prediction error of one channel, ORDER samples shorter."""
    return np.convolve(x, weights, mode="valid")


def loudness_features(look: Array, weights: Array, lengths: list[int], floor: float) -> Array:
    """Return the 16 features of a look: of the signal, then of its prediction error."""
    n, recent = len(look), lengths[-1]
    error = np.append(np.zeros(ORDER), prediction_error(look, weights))
    out = []
    for x, missing in ((look - look[: n - recent].mean(), 0), (error, ORDER)):
        power = x**2
        quiet, newest = power[: n - recent], power[n - lengths[-2] :]
        level = [
            quiet.sum() / (len(quiet) - missing),
            *(power[n - k :].mean() for k in lengths[:-1]),
            power[n - recent : n - lengths[-2]].mean(),
            newest.max(),
            quiet.max(),
        ]
        logs = np.log(np.sqrt(level) + floor)
        out += [logs[0], *(logs[1:-2] - logs[0]), logs[-2] - logs[-1]]
    return np.array(out)


def onset(window: Array, search: int) -> int:
    """Return the split that best separates quiet from loud (Maeda's picker)."""
    n = len(window)
    splits = range(max(3, n - search), n - 2)

    def log_variance(x: Array) -> float:
        return log(max(1e-6, x @ x / len(x) - (x.sum() / len(x)) ** 2))

    aic = [k * log_variance(window[:k]) + (n - k - 1) * log_variance(window[k:]) for k in splits]
    return splits[int(np.argmin(aic))]


# One closing


class Closing:
    """Contacts and withdrawals of one closing."""

    def __init__(self, stream: Stream, start: int, x: Array) -> None:
        """Take all smoothed samples from the start of the closing on, shape (n, channels)."""
        self.stream, self.start, self.x = stream, start, x
        self.c = stream.constants
        self.is_confirmed = stream.is_by_hand or stream.keeps_first_state
        self.waiting: tuple[int, int, int] | None = None  # channel, sample, decided
        self.not_before = 0
        self.latched: set[int] = set()

    def events(self) -> Iterator[Event]:
        """Yield the events in order."""
        c, s = self.c, self.stream
        every, age = s.samples(0.01), samples_in(0.008, s.rate)
        settles, has_state = c.steady, False
        for end in range(1, len(self.x) + 1):
            yield from self._confirm(end)
            if not np.isfinite(self.x[end - 1]).all():
                settles, has_state = end + c.steady, False
            elif not has_state and end == settles:
                self._settle(end)
                has_state, window_end = True, end + c.step
            elif has_state and end == window_end:
                window_end += c.step
                yield from self._judge(end)
            yield from self._confirm(end)
            begin = end - age - c.steady
            if end % every == 0 and has_state and not self.is_confirmed and begin >= 0:
                self._resettle(begin)

    def _settle(self, end: int) -> None:
        quiet = self.x[end - self.c.steady : end]
        self.mean, self.sigma = measure(quiet)
        self.weights = [self._weights(quiet, k) for k in range(self.x.shape[1])]

    def _resettle(self, begin: int) -> None:
        quiet = self.x[begin : begin + self.c.steady]
        mean, sigma = measure(quiet)
        for k in np.flatnonzero((sigma > 0) & (sigma < 0.9 * self.sigma)).tolist():
            self.mean[k], self.sigma[k] = mean[k], sigma[k]
            self.weights[k] = self._weights(quiet, k)

    def _weights(self, quiet: Array, k: int) -> Array:
        if self.c.kind != DetectorKind.LOGISTIC or not self.sigma[k] > 0:
            return np.zeros(ORDER + 1)
        return prediction((quiet[:, k] - self.mean[k]) / self.sigma[k])

    def _judge(self, end: int) -> Iterator[Event]:
        c = self.c
        alive = np.flatnonzero(self.sigma > 0).tolist()
        z = (self.x[end - c.window : end, alive] - self.mean[alive]) / self.sigma[alive]
        fired = np.asarray((np.abs(z[-c.step :]) > c.threshold).any(axis=0)).tolist()
        if not any(fired):
            return
        if c.kind == DetectorKind.LOGISTIC:
            fired = [self._looks_agree(z[:, j], self.weights[k]) for j, k in enumerate(alive)]
        found = sorted(
            (self.start + end - c.window + onset(z[:, j], c.search), k)
            for j, k in enumerate(alive)
            if fired[j]
        )
        for sample, k in found:
            if k not in self.latched and sample >= self.not_before:
                is_first = not self.latched
                self.latched.add(k)
                known = self.start + end - 1
                if is_first and not self.is_confirmed:
                    self.waiting = k, sample, known
                flags = Flag.FIRST if is_first else 0
                yield EventKind.CONTACT_FOUND, 0, flags, k, sample, known

    def _looks_agree(self, z: Array, weights: Array) -> bool:
        c = self.c
        length = c.window - (c.looks - 1) * c.step
        return all(
            loudness_features(z[k : k + length], weights, list(c.lengths), c.floor) @ c.line[:-1]
            + c.line[-1]
            > 0
            for k in range(0, c.looks * c.step, c.step)
        )

    def _confirm(self, end: int) -> Iterator[Event]:
        """Confirm or withdraw the first contact if the samples before ``end`` suffice."""
        if self.waiting is None:
            return
        k, sample, decided = self.waiting
        due = max(sample + max(2, samples_in(0.003, self.stream.rate)) - 1, decided)
        if self.start + end - 1 < due:
            return
        self.waiting = None
        if self._is_push(self.x[:, k], sample - self.start):
            self.is_confirmed = True
            return
        yield EventKind.CONTACT_WITHDRAWN, 0, Flag.FIRST, k, sample, due
        self.not_before = sample + 1
        self.latched.clear()

    def _is_push(self, x: Array, place: int) -> bool:
        """Return True if the signal after a contact is slow and loud, or very loud."""
        s = self.stream
        before = samples_in(0.017, s.rate)
        before = before + 1 if s.rate < 2 / 0.017 else max(1, before)
        earlier = x[max(0, place - before) : max(0, place - samples_in(0.001, s.rate))]
        if not len(earlier) or (earlier == earlier[0]).all():
            return True
        later = x[place : place + max(2, samples_in(0.003, s.rate))] - earlier.mean()
        lag, lasting = s.samples(0.0002), s.samples(0.002)
        is_rough = np.abs(later[lag:] - later[:-lag]).sum() > 0.35 * np.abs(later).sum()
        newest = np.sqrt((later[-lasting:] ** 2).mean())
        return not newest <= (20.0 if is_rough else 4.0) * earlier.std()


# The whole stream


def smoothed(x: Array, alpha: Array) -> Array:
    """Return smoothed samples. Smoothing restarts after samples that are not finite."""
    out = np.full(x.shape, np.nan)
    state, last = x[0], -2
    for n in np.flatnonzero(np.isfinite(x).all(axis=1)).tolist():
        state = alpha * x[n] + (1 - alpha) * state if n == last + 1 else x[n]
        out[n], last = state, n
    return out


def run(stream: Stream, stretches: list[Stretch]) -> list[Event]:
    """Return the events of a stream until its end. Stretches are separated by gaps or epochs."""
    events: list[Event] = []
    step, grid, epoch, end = stream.samples(0.003), 0, None, 0
    for stretch in stretches:
        is_same = stretch.epoch == epoch
        last = _Pending(stream, events)
        gate = Gate(stream)
        x = smoothed(stretch.vibration, stream.alpha)
        if stream.floors is None:
            if not is_same:
                last.begin(stretch.first, x)
            last.upto(stretch.end, gate)
        else:
            grid = stretch.first + ((grid - stretch.first) % step if is_same else 0)
            part = slice(grid - stretch.first, None)
            quiet = quiet_steps(in_steps(stretch.vibration[part], step), stream.floors)
            levels = in_steps(stretch.loads[part], step).mean(axis=1)
            for is_quiet, level in zip(quiet, levels, strict=True):
                grid += step
                last.upto(grid, gate)
                shuts, opens = gate.step(is_quiet, level, grid)
                if shuts:
                    last.finish(grid, Reason.RESTED)
                if opens:
                    last.begin(grid, x[grid - stretch.first :])
            last.upto(stretch.end, gate)
        epoch, end = stretch.epoch, stretch.end
        is_last = stretch is stretches[-1]
        last.finish(end, Reason.STREAM_ENDED if is_last else Reason.LOST)
    return events


def in_steps(x: Array, step: int) -> Array:
    """Return the complete steps, shape (steps, samples, channels)."""
    n = len(x) // step
    return x[: n * step].reshape(n, step, x.shape[1])


class _Pending:
    """Events of the current closing that are not known yet."""

    def __init__(self, stream: Stream, events: list[Event]) -> None:
        self.stream, self.events = stream, events
        self.pending: list[Event] = []
        self.is_open = False
        self.first: tuple[int, int] | None = None  # channel and sample of the first contact
        self.over = 0

    def begin(self, start: int, x: Array) -> None:
        self.events.append((EventKind.CLOSING_BEGAN, 0, 0, -1, start, start - 1))
        self.is_open, self.first = True, None
        has_detector = self.stream.constants.kind != DetectorKind.NONE
        self.closing = Closing(self.stream, start, x)
        self.source = self.closing.events() if has_detector else iter(())
        self.next = next(self.source, None)

    def upto(self, end: int, gate: Gate) -> None:
        """Emit the events that depend on samples before ``end`` only."""
        while self.is_open and self.next is not None:
            kind, *_, channel, sample, known = self.next
            if self._ends_before(known) or known >= end:
                break
            self.events.append(self.next)
            if kind == EventKind.CONTACT_FOUND:
                if gate.stream.is_by_hand:
                    gate.due = sample + samples_in(0.3, self.stream.rate)
                if self.first is None:
                    self.first = channel, sample
                    self.decided = known
            else:
                self.first = None
            self.next = next(self.source, None)
        if self.is_open and self._ends_before(end):
            self.finish(self.first[1] + self.stream.samples(self.stream.after), Reason.DONE)

    def _ends_before(self, known: int) -> bool:
        """Return True if the time after the first contact is over before sample ``known``."""
        if self.first is None:
            return False
        is_stand = self.stream.is_by_hand or self.stream.keeps_first_state
        wait = max(2, samples_in(0.003, self.stream.rate))
        confirmed = self.decided if is_stand else max(self.first[1] + wait - 1, self.decided)
        end = self.first[1] + self.stream.samples(self.stream.after)
        return max(end, confirmed + 1, self.decided + 1) <= known

    def finish(self, sample: int, reason: Reason) -> None:
        if self.is_open:
            channel = -1 if self.first is None else self.first[0]
            self.events.append((EventKind.CLOSING_ENDED, reason, 0, channel, sample, sample - 1))
        self.is_open = False
