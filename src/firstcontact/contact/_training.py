"""Training windows for contact detectors."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from firstcontact.contact._features import feature_count, window_features
from firstcontact.contact._steady_state import SteadyState
from firstcontact.contact._window_detector import WindowSizes
from firstcontact.core import ChannelKind, Dataset, Pinch
from firstcontact.signal import DeviceSmoothing, samples_in

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
    """Return the group of each pinch. A group is a session, and stays in one fold."""
    names, numbers = np.unique(sessions, return_inverse=True)
    return np.arange(len(sessions)) if len(names) < folds else numbers.astype(np.intp)


@dataclass(frozen=True, slots=True, eq=False)
class TrainingWindows:
    """Features and labels of windows from many pinches."""

    features: NDArray[np.float64]
    positive: NDArray[np.bool_]
    pinch: NDArray[np.intp]
    first: NDArray[np.bool_]
    phase: NDArray[np.intp]

    def take(self, selection: NDArray[np.bool_] | NDArray[np.intp]) -> TrainingWindows:
        """Return the selected windows."""
        return TrainingWindows(*(getattr(self, f.name)[selection] for f in fields(self)))


def usable(pinch: Pinch, sizes: WindowSizes, early: float) -> bool:
    """Return True if the first contact is known, and the samples before it suffice for training."""
    if pinch.first is None:
        return False
    room = pinch.first.sample - pinch.first_sample - samples_in(early, pinch.layout.rate)
    return room >= sizes.steady + sizes.step


def training_windows(
    dataset: Dataset, sizes: WindowSizes, early: float, seed: int
) -> TrainingWindows:
    """Return the training windows of all usable pinches."""
    rng = np.random.default_rng(seed)
    empty = TrainingWindows(
        np.zeros((0, feature_count(sizes.step))),
        np.zeros(0, np.bool_),
        np.zeros(0, np.intp),
        np.zeros(0, np.bool_),
        np.zeros(0, np.intp),
    )
    parts = [empty] + [
        _finger_windows(i, pinch, column, sizes, early, rng)
        for i, pinch in enumerate(dataset.pinches)
        if usable(pinch, sizes, early)
        for column in range(len(pinch.layout.vibration_fingers))
    ]
    combined = (
        np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(TrainingWindows)
    )
    return TrainingWindows(*combined)


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
