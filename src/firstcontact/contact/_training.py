"""Windows to train a contact detector on."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from firstcontact.contact._features import feature_count, window_features
from firstcontact.contact._stream import SteadyState, WindowSizes
from firstcontact.core import ChannelKind, Dataset, Pinch
from firstcontact.signal import DeviceSmoothing, samples_in

#: A contact younger than this, s, looks like the start of a click of the gears:
#: such windows teach nothing. Chosen with gamma and cost in folds of the training
#: sessions of the twin (0.0010 or 0.0014).
YOUNGEST = 0.0014
#: Places of the grid of windows relative to a contact that are trained on.
PHASES = 3
#: Windows that may show it, wherever the grid lies: it is in the newest part of
#: one, and in the step before in the next, a second chance for faint starts.
CHANCES = 2


def session_groups(sessions: NDArray[np.str_], folds: int) -> NDArray[np.intp]:
    """Number of each pinch's session; each pinch its own where there are too few."""
    names, numbers = np.unique(sessions, return_inverse=True)
    return np.arange(len(sessions)) if len(names) < folds else numbers.astype(np.intp)


@dataclass(frozen=True, slots=True, eq=False)
class TrainingWindows:
    """Windows of many pinches, as features.

    Parameters
    ----------
    features
        Shape (windows, features).
    positive
        Whether a contact began in its recent part, shape (windows,).
    pinch
        Which pinch each is from, shape (windows,).
    first
        Whether it speaks of the first contact of its pinch: a window before it
        (of either finger), or one that shows it, shape (windows,).
    phase
        Where the grid lies relative to the contact, 0 where there is none,
        shape (windows,).
    """

    features: NDArray[np.float64]
    positive: NDArray[np.bool_]
    pinch: NDArray[np.intp]
    first: NDArray[np.bool_]
    phase: NDArray[np.intp]

    def take(self, which: NDArray[np.bool_] | NDArray[np.intp]) -> TrainingWindows:
        """Some of them."""
        return TrainingWindows(*(getattr(self, f.name)[which] for f in fields(self)))


def usable(pinch: Pinch, sizes: WindowSizes, early: float) -> bool:
    """Whether the first contact is known and leaves a steady state and a window before it."""
    if pinch.first is None:
        return False
    before = pinch.first.sample - pinch.first_sample - samples_in(early, pinch.layout.rate)
    return before >= sizes.steady + sizes.step


def training_windows(
    dataset: Dataset, sizes: WindowSizes, early: float, seed: int
) -> TrainingWindows:
    """Windows of all usable pinches.

    Negatives: each finger before its own contact, one window a step at a random
    phase; where the second contact is not known, only what lies before the
    first. Positives: each contact at several ages from 1.4 ms to two steps more.

    Parameters
    ----------
    dataset
        The pinches, each from where its closing starts.
    sizes
        Lengths at their rate.
    early
        The contact may be up to this much earlier than its label, s.
    seed
        For the phases.
    """
    rng = np.random.default_rng(seed)
    nothing = TrainingWindows(
        np.zeros((0, feature_count(sizes.step))),
        np.zeros(0, np.bool_),
        np.zeros(0, np.intp),
        np.zeros(0, np.bool_),
        np.zeros(0, np.intp),
    )
    parts = [nothing] + [
        _of_finger(i, pinch, column, sizes, early, rng)
        for i, pinch in enumerate(dataset.pinches)
        if usable(pinch, sizes, early)
        for column in range(len(pinch.layout.vibration_fingers))
    ]
    joined = (np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(TrainingWindows))
    return TrainingWindows(*joined)


def _of_finger(
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
    steady = SteadyState.of(smooth[: sizes.steady])
    x = steady.normalise(smooth)[:, 0]
    margin = samples_in(early, layout.rate)
    youngest = samples_in(YOUNGEST, layout.rate)
    first = pinch.truth[0].sample - pinch.first_sample
    finger = layout.vibration_fingers[column]
    touched = [c.sample - pinch.first_sample for c in pinch.truth if c.finger is finger][:1]
    quiet_end = (touched or [first])[0] - margin
    shift = int(rng.integers(sizes.step))
    before = np.arange(sizes.steady + sizes.step - shift, quiet_end + 1, sizes.step)
    steps = np.arange(PHASES * CHANCES) * sizes.step / PHASES
    after = np.array([t + youngest + step for t in touched for step in steps], dtype=np.intp)
    ends = np.concatenate([before, after])
    phase = np.concatenate([np.zeros_like(before), np.arange(len(after)) % PHASES])
    whole = ends <= (len(x) if steady.alive[0] else 0)
    ends, phase = ends[whole], phase[whole]
    windows = sliding_window_view(x, sizes.window)[ends - sizes.window]
    positive = ends > quiet_end
    is_first = np.full(len(ends), touched == [first]) | (ends <= first - margin)
    return TrainingWindows(
        window_features(np.ascontiguousarray(windows), sizes.step),
        positive,
        np.full(len(ends), number, dtype=np.intp),
        is_first,
        phase,
    )
