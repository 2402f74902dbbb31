"""Training data of contact detectors: motor noise before contacts, and windows with features."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from firstcontact.contact.detector import WindowSizes, usable
from firstcontact.core import ChannelKind, Dataset, Pinch
from firstcontact.signal import DeviceSmoothing, samples_in

#: A later steady state counts if its sigma is below this share of the earlier one.
QUIETER = 0.9


@dataclass(frozen=True, slots=True, eq=False)
class SteadyState:
    """Mean and standard deviation of the motor's noise in each channel, shape (fingers,)."""

    mean: NDArray[np.float64]
    sigma: NDArray[np.float64]

    @classmethod
    def measure(cls, quiet: NDArray[np.float64]) -> SteadyState:
        """Measure the steady state in samples before a contact, shape (samples, fingers)."""
        # A range detects constant channels exactly. The standard deviation rounds.
        sigma = np.where(np.ptp(quiet, axis=0) > 0.0, quiet.std(axis=0), 0.0)
        return cls(quiet.mean(axis=0), sigma)

    @property
    def alive(self) -> NDArray[np.bool_]:
        """Mask of the channels that vary. The others are unplugged or saturated."""
        return self.sigma > 0.0

    def is_louder_than(self, later: SteadyState) -> NDArray[np.bool_]:
        """Return a mask of the channels whose noise is clearly weaker in ``later``."""
        return np.asarray(later.alive & (later.sigma < QUIETER * self.sigma))

    def normalise(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return samples in standard deviations from the mean; 0 for constant channels."""
        scale = np.where(self.alive, self.sigma, 1.0)
        return np.where(self.alive, (x - self.mean) / scale, 0.0)


#: Number of parts into which the quiet part of a window, and each of its two recent steps, is
#: divided.
PARTS = 3
#: Number of means that describe the step before the newest step.
COARSE = 5
#: Added to an RMS, in sigmas, before its logarithm. Smaller levels do not matter.
FLOOR = 0.1


def feature_count(step: int) -> int:
    """Return the number of features of a window whose newest step has ``step`` samples."""
    return step + COARSE + 6 * PARTS + 2


def _means(x: NDArray[np.float64], edges: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return the mean of each span of the last axis of ``x``, between neighbouring ``edges``."""
    pieces = x[..., : edges[-1]]
    out: NDArray[np.float64] = np.add.reduceat(pieces, edges[:-1], axis=-1) / np.diff(edges)
    return out


@lru_cache(maxsize=64)
def _part_edges(start: int, stop: int, parts: int) -> NDArray[np.intp]:
    return np.linspace(start, stop, parts + 1).astype(np.intp)


@lru_cache(maxsize=64)
def _loudness_edges(quiet: int, new: int, n: int) -> NDArray[np.intp]:
    """Return the ten edges of nine spans of a window of ``n`` samples, for :func:`_means`.

    Three spans are before the sample ``quiet``, three between ``quiet`` and ``new``, three after
    ``new``.
    """
    spans = ((0, quiet), (quiet, new), (new, n))
    return np.append(np.concatenate([_part_edges(*span, PARTS)[:-1] for span in spans]), n)


def window_features(windows: NDArray[np.float64], step: int) -> NDArray[np.float64]:
    """Return features of windows (n, samples): the newest waveform, and loudness in nine spans.

    ``step`` is the number of samples of the newest part.
    """
    count, n = windows.shape
    new, quiet = n - step, n - 2 * step
    # Row 0 is the signal, row 1 its differences. Each operation below handles both.
    both = np.zeros((2, count, n))
    centred, slope = both
    np.subtract(windows, windows[:, :quiet].mean(axis=1, keepdims=True), out=centred)
    np.subtract(centred[:, 1:], centred[:, :-1], out=slope[:, 1:])
    loudness = np.log(np.sqrt(_means(both**2, _loudness_edges(quiet, new, n))) + FLOOR)
    tops = np.log(np.maximum.reduceat(np.abs(both), (0, quiet), axis=2) + FLOOR)
    peaks = tops[:, :, 1] - tops[:, :, 0]
    recent_means = _means(centred[:, :new], _part_edges(quiet, new, COARSE))
    return np.concatenate(
        [np.arcsinh(centred[:, new:]), np.arcsinh(recent_means), *loudness, peaks.T], axis=1
    )


#: Youngest contact in training windows, s. A younger one looks like the start of a click of the
#: gears. Chosen with gamma and cost on folds of the twin's training sessions (from 0.0010 and
#: 0.0014).
YOUNGEST = 0.0014
#: Number of positions of the window grid relative to a contact in training.
PHASES = 3
#: Number of windows that can show a contact: one with the contact in its newest part, and the next,
#: as a second chance for faint starts.
CHANCES = 2


def session_groups(sessions: NDArray[np.str_], folds: int) -> NDArray[np.intp]:
    """Return a group number per pinch for cross-validation, equal within a session.

    With fewer sessions than ``folds``, each pinch is its own group.
    """
    names, numbers = np.unique(sessions, return_inverse=True)
    return np.arange(len(sessions)) if len(names) < folds else numbers.astype(np.intp)


@dataclass(frozen=True, slots=True, eq=False)
class TrainingWindows:
    """Features and labels of windows from many pinches, one row per window.

    ``positive`` marks windows after their finger's contact. ``pinch`` is the pinch's number.
    ``first`` marks windows before the pinch's first contact or at it. ``phase`` numbers the offset
    of the grid of windows from the contact.
    """

    features: NDArray[np.float64]
    positive: NDArray[np.bool_]
    pinch: NDArray[np.intp]
    first: NDArray[np.bool_]
    phase: NDArray[np.intp]

    def take(self, selection: NDArray[np.bool_] | NDArray[np.intp]) -> TrainingWindows:
        return TrainingWindows(*(getattr(self, f.name)[selection] for f in fields(self)))


def training_windows(
    dataset: Dataset, sizes: WindowSizes, early: float, seed: int
) -> TrainingWindows:
    """Cut labelled windows from all usable pinches (see :func:`usable`), to train the SVM."""
    rng = np.random.default_rng(seed)
    parts = [
        _finger_windows(i, pinch, column, sizes, early, rng)
        for i, pinch in enumerate(dataset.pinches)
        if usable(pinch, sizes, early)
        for column in range(len(pinch.layout.vibration_fingers))
    ]
    if not parts:
        none = np.zeros(0, np.intp)
        return TrainingWindows(np.zeros((0, 0)), none > 0, none, none > 0, none)
    names = [f.name for f in fields(TrainingWindows)]
    return TrainingWindows(*(np.concatenate([getattr(p, name) for p in parts]) for name in names))


def _finger_windows(
    number: int,
    pinch: Pinch,
    column: int,
    sizes: WindowSizes,
    early: float,
    rng: np.random.Generator,
) -> TrainingWindows:
    layout = pinch.layout
    columns = layout.columns(ChannelKind.VIBRATION)[column : column + 1]
    smooth = DeviceSmoothing(layout, columns).update(pinch.vibration()[:, column : column + 1])
    steady = SteadyState.measure(smooth[: sizes.steady])
    x = steady.normalise(smooth)[:, 0]
    margin = samples_in(early, layout.rate)
    youngest = samples_in(YOUNGEST, layout.rate)
    first = pinch.truth[0].sample - pinch.first_sample
    finger = layout.vibration_fingers[column]
    contacts_of_finger = [c.sample - pinch.first_sample for c in pinch.truth if c.finger is finger][
        :1
    ]
    quiet_end = (contacts_of_finger or [first])[0] - margin
    shift = int(rng.integers(sizes.step))
    ends_before = np.arange(sizes.steady + sizes.step - shift, quiet_end + 1, sizes.step)
    steps = np.arange(PHASES * CHANCES) * sizes.step / PHASES
    ends_after = np.array(
        [t + youngest + step for t in contacts_of_finger for step in steps], dtype=np.intp
    )
    ends = np.concatenate([ends_before, ends_after])
    phase = np.concatenate([np.zeros_like(ends_before), np.arange(len(ends_after)) % PHASES])
    is_complete = ends <= (len(x) if steady.alive[0] else 0)
    ends, phase = ends[is_complete], phase[is_complete]
    windows = sliding_window_view(x, sizes.window)[ends - sizes.window]
    positive = ends > quiet_end
    is_first = np.full(len(ends), contacts_of_finger == [first]) | (ends <= first - margin)
    return TrainingWindows(
        window_features(np.ascontiguousarray(windows), sizes.step),
        positive,
        np.full(len(ends), number, dtype=np.intp),
        is_first,
        phase,
    )
