"""Base class of detectors that judge sliding windows. It handles stream, steady state and latch."""

from __future__ import annotations

import itertools
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from firstcontact.contact._detector import WindowDecisions, latch
from firstcontact.contact._onset import LEAST_LOUD, pick_onset
from firstcontact.core import (
    SKY,
    Block,
    ChannelKind,
    Contact,
    Dataset,
    Finger,
    InputError,
    Judgement,
    Layout,
    Physical,
)
from firstcontact.signal import DeviceSmoothing, samples_in

#: Longest piece of a block that is processed at once, samples. It bounds the memory.
PIECE = 30_000
#: A later steady state counts if its sigma is below this share of the earlier one.
QUIETER = 0.9
#: Up to this number of windows, copying them one by one is faster than a view of all windows.
FEW = 4


@dataclass(frozen=True, slots=True)
class WindowSizes:
    """Lengths of window, step and steady state in samples, at one rate."""

    window: int
    step: int
    steady: int


@dataclass(frozen=True, slots=True, eq=False)
class SteadyState:
    """Mean and sigma of each vibration channel before any contact, shape (fingers,)."""

    mean: NDArray[np.float64]
    sigma: NDArray[np.float64]

    @classmethod
    def measure(cls, quiet: NDArray[np.float64]) -> SteadyState:
        """Return the steady state in ``quiet``, samples of shape (samples, fingers)."""
        # A range detects constant channels exactly. The standard deviation rounds.
        sigma = np.where(np.ptp(quiet, axis=0) > 0.0, quiet.std(axis=0), 0.0)
        return cls(quiet.mean(axis=0), sigma)

    @property
    def alive(self) -> NDArray[np.bool_]:
        """Mask of channels that vary. The others are unplugged or saturated."""
        return self.sigma > 0.0

    def is_louder_than(self, later: SteadyState) -> NDArray[np.bool_]:
        """Return a mask of the channels that a later steady state shows clearly quieter."""
        return np.asarray(later.alive & (later.sigma < QUIETER * self.sigma))

    def normalise(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the difference from the mean in sigmas; 0 for constant channels."""
        scale = np.where(self.alive, self.sigma, 1.0)
        return np.where(self.alive, (x - self.mean) / scale, 0.0)


class WindowDetector(ABC):
    """Detector that judges a window of ``duration`` after every ``step`` of new samples.

    The steady state is measured in the first 40 ms of a stream, and again in the first 40 ms after
    each gap. Decisions begin after the steady state. So a stream must start where a closing does:
    the gate ensures this live, and :func:`firstcontact.contact._closing_start.cut_closings` for
    pinches. A contact during the steady state makes its sigma large, so later contacts may be
    missed. A channel that is constant during the steady state never fires.
    """

    name: ClassVar[str]
    title: ClassVar[str] = ""
    colour: ClassVar[str] = SKY
    learns: ClassVar[bool] = False
    #: 17 ms of old and 3 ms of new samples, as published.
    duration: ClassVar[float] = 0.020
    step: ClassVar[float] = 0.003
    #: Two periods of 50 Hz hum.
    steady: ClassVar[float] = 0.040
    #: Number of newest steps in which a detected contact can have begun: the new part, and two
    #: steps before for contacts that were too faint.
    reach: ClassVar[int] = 3

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "title" not in vars(cls) and "name" in vars(cls):
            cls.title = cls.name.replace("_", " ")

    @property
    def rate(self) -> float | None:
        """Required sampling rate, Hz; None, the default, accepts any."""
        return None

    def fit(self, dataset: Dataset, early: float = 0.0) -> Self:
        """Learn from pinches with known contacts. By default do nothing."""
        return self

    @classmethod
    def untrained(cls, layout: Layout) -> Self:
        """Return a detector for a layout without training data, by default with default options."""
        return cls()

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        """Return all learned numbers and options for saving. By default there are none."""
        return {}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Restore a detector from :meth:`to_arrays`. By default return a new one."""
        return cls()

    @abstractmethod
    def fires(self, windows: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return a mask of the windows with a contact in their newest part.

        Parameters
        ----------
        windows
            Shape (windows, fingers, samples), in sigmas of the steady state.

        Returns
        -------
        ndarray
            Shape (windows, fingers).
        """

    def settled(self, quiet: NDArray[np.float64]) -> None:  # noqa: B027
        """Learn from a steady state. By default do nothing.

        This method is called when the first steady state is complete, and again when a quieter one
        replaces it.

        Parameters
        ----------
        quiet
            Samples of the steady state, in its sigmas, shape (samples, fingers).
        """

    def wakes(self, x: NDArray[np.float64], ends: NDArray[np.intp]) -> NDArray[np.bool_]:
        """Return a mask of the windows that :meth:`fires` must judge. No other window fires.

        By default all windows are judged.

        Parameters
        ----------
        x
            Shape (samples, fingers), in sigmas of the steady state.
        ends
            Position in ``x`` of the first sample after each window, shape (windows,).

        Returns
        -------
        ndarray
            Shape (windows,). Each value may depend only on the samples of its window.
        """
        return np.ones(len(ends), np.bool_)

    def judgement(self, rate: float) -> Judgement:
        """Return this detector as a C kernel that works sample by sample, for export.

        Raises
        ------
        InputError
            The detector has no sample-by-sample form.
        """
        raise InputError(
            f"the detector {self.name!r} cannot judge one sample after the other, as an exported "
            "detector must: train with another --detector-type"
        )

    @classmethod
    def sizes(cls, rate: float) -> WindowSizes:
        """Return the lengths of window, step and steady state, in samples, at a rate in Hz."""
        return WindowSizes(
            samples_in(cls.duration, rate),
            max(1, samples_in(cls.step, rate)),
            samples_in(cls.steady, rate),
        )

    def start(self, layout: Layout) -> None:
        """Start a new closing: forget all earlier samples and contacts.

        Raises
        ------
        InputError
            The layout has no vibration channel, or its rate is too low.
        """
        if not layout.vibration_fingers:
            raise InputError(
                "the recording or device has no vibration channel, so contacts cannot be "
                "detected: use one with a vibration sensor"
            )
        self._sizes = self.sizes(layout.rate)
        if self._sizes.window < 2 * LEAST_LOUD:
            raise InputError(
                f"the detector {self.name!r} cannot locate contacts in samples at {layout.rate:g} "
                f"Hz: use a sensor with {2 * LEAST_LOUD / self.duration:g} Hz or more"
            )
        self._layout = layout
        self._columns = layout.columns(ChannelKind.VIBRATION)
        self._fingers = layout.vibration_fingers
        self._volts = Physical(layout, self._columns)
        self._latched: set[Finger | None] = set()
        self._epoch = 0
        self._restart(0)

    def _restart(self, first_sample: int) -> None:
        self._smoothing = DeviceSmoothing(self._layout)
        self._state: SteadyState | None = None
        #: Samples that later windows need, and the number of the first of these samples.
        self._past = np.zeros((0, len(self._columns)))
        self._past_first = first_sample
        self._next = first_sample
        self._window_end = first_sample + self._sizes.steady + self._sizes.step

    @property
    def due(self) -> int:
        """Number of samples until the next decision."""
        return self._window_end - self._next

    @property
    def steady_samples(self) -> int:
        """Number of samples of a steady state."""
        return self._sizes.steady

    def resettle(self, quiet: NDArray[np.float64]) -> bool:
        """Replace the steady state of the channels that have become quieter.

        Parameters
        ----------
        quiet
            Smoothed samples from later in the closing, before any contact, V, shape (steady,
            fingers).

        Returns
        -------
        bool
            True if a channel has become quieter.
        """
        is_quieter = self._quieter(quiet)
        if is_quieter.any():
            self._settle(np.where(is_quieter, quiet, self._quiet))
        return bool(is_quieter.any())

    def may_resettle(self, quiet: NDArray[np.float64]) -> bool:
        """Return False if :meth:`resettle` would surely change nothing with ``quiet``."""
        return self._state is None or bool(self._quieter(quiet).any())

    def restarts(self, block: Block) -> bool:
        """Return True if a block begins a new stream, or has samples that are not finite."""
        if block.epoch != self._epoch or block.first_sample != self._next:
            return True
        return block.data.dtype.kind != "i" and not bool(np.isfinite(block.data).all())

    def _quieter(self, quiet: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return a mask of the channels that have become quieter; none before a steady state."""
        if self._state is None:
            return np.zeros(len(self._columns), np.bool_)
        return self._state.is_louder_than(SteadyState.measure(quiet))

    def _settle(self, quiet: NDArray[np.float64]) -> None:
        self._quiet = quiet
        self._state = SteadyState.measure(quiet)
        self.settled(self._state.normalise(quiet))

    def skip(self, fingers: Iterable[Finger | None]) -> None:
        """Stop judging these fingers in this closing, because their contacts are known."""
        self._latched = set(fingers)

    def judge(self, block: Block) -> WindowDecisions:
        """Return the decisions for the windows that this block completes."""
        if block.epoch != self._epoch:
            self._epoch = block.epoch
            self._restart(block.first_sample)
        volts = self._volts(block.data)
        parts = []
        # Integers are always finite, and live blocks are short.
        short = 0 < len(volts) <= PIECE and block.data.dtype.kind == "i"
        runs = [(block.first_sample, volts)] if short else finite_runs(volts, block.first_sample)
        for first, run in runs:
            if first != self._next:
                self._restart(first)
            parts.append(self._judge_run(run))
        if len(parts) == 1:
            return parts[0]
        fingers = len(self._columns)
        return WindowDecisions(
            np.concatenate([np.zeros(0, np.int64), *(p.ends for p in parts)]),
            np.concatenate([np.zeros((0, fingers), np.bool_), *(p.fired for p in parts)]),
            np.concatenate([np.zeros((0, fingers), np.int64), *(p.onsets for p in parts)]),
        )

    def update(self, block: Block) -> list[Contact]:
        """Return the contacts that this block reveals, at most one per finger and closing."""
        return latch(self.judge(block), self._fingers, self._latched)

    def _judge_run(self, volts: NDArray[np.float64]) -> WindowDecisions:
        sizes = self._sizes
        new = self._smoothing.update(volts)
        self._past = np.concatenate([self._past, new])
        self._next += len(volts)
        if self._state is None and len(self._past) >= sizes.steady:
            self._settle(self._past[: sizes.steady].copy())
        ends = np.arange(self._window_end, self._next + 1, sizes.step)
        if self._state is None or not len(ends):
            none = np.zeros((0, len(self._columns)))
            return WindowDecisions(
                np.zeros(0, np.int64), none.astype(np.bool_), none.astype(np.int64)
            )
        fired, onsets = self._judge_windows(self._state, ends)
        self._window_end = int(ends[-1]) + sizes.step
        surplus = self._window_end - sizes.window - self._past_first
        self._past = self._past[surplus:].copy()
        self._past_first += surplus
        return WindowDecisions(ends - 1, fired, onsets)

    def _judge_windows(
        self, state: SteadyState, ends: NDArray[np.int64]
    ) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
        """Return decisions and onsets for the windows of stored samples that end at ``ends``."""
        sizes = self._sizes
        x = state.normalise(self._past)
        fired = np.zeros((len(ends), x.shape[1]), np.bool_)
        onsets = np.full(fired.shape, -1, dtype=np.int64)
        candidates = np.flatnonzero(self.wakes(x, ends - self._past_first))
        if len(candidates):
            starts = ends[candidates] - sizes.window
            windows = _windows(x, starts - self._past_first, sizes.window)
            has_contact = self.fires(windows) & state.alive
            fired[candidates] = has_contact
            if has_contact.any():
                picked = pick_onset(windows[has_contact], self.reach * sizes.step)
                onsets[fired] = picked + starts[np.nonzero(has_contact)[0]]
        return fired, onsets


def _windows(
    x: NDArray[np.float64], starts: NDArray[np.int64], samples: int
) -> NDArray[np.float64]:
    """Return the windows of ``x`` at ``starts``, shape (windows, fingers, samples)."""
    if len(starts) > FEW:
        return np.ascontiguousarray(sliding_window_view(x, samples, axis=0)[starts])
    out = np.empty((len(starts), x.shape[1], samples))
    for window, start in zip(out, starts.tolist(), strict=True):
        window[:] = x[start : start + samples].T
    return out


def finite_runs(
    volts: NDArray[np.float64], first_sample: int
) -> Iterator[tuple[int, NDArray[Any]]]:
    """Yield each stretch of finite samples, with the number of its first sample."""
    bad = np.flatnonzero(~np.isfinite(volts).all(axis=1))
    edges = [-1, *bad.tolist(), len(volts)]
    for a, b in itertools.pairwise(edges):
        for start in range(a + 1, b, PIECE):
            yield first_sample + start, volts[start : min(b, start + PIECE)]
