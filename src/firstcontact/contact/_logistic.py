"""Contact detector with a logistic regression on loudness.

It looks every 0.4 ms. Four consecutive looks must agree.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact._closing_start import cut_closings
from firstcontact.contact._logistic_training import (
    LOOKS,
    best_threshold,
    cut_looks,
    fit_line,
    scores,
)
from firstcontact.contact._loudness import (
    EACH,
    FLOOR,
    ORDER,
    RIDGE,
    logarithm_weights,
    loudness_features,
    parts,
    prediction,
)
from firstcontact.contact._stream import SteadyState
from firstcontact.contact._trained import TrainedDetector, spread_out, stored_array
from firstcontact.contact._training import session_groups
from firstcontact.core import (
    GREEN,
    Constants,
    Dataset,
    InputError,
    Judgement,
    kernels,
)

#: Least deviation of a new sample, in sigmas, for which a window is evaluated.
AWAKE = 3.0
#: Largest number of training pinches, and number of folds for the threshold.
PINCHES = 1000
FOLDS = 3
#: Number of looks whose scores the kernel remembers for each finger.
_REMEMBERED = 8
#: Largest error of the approximate logarithms in C, doubled for safety.
ROUGH = 4e-5


class LogisticDetector(TrainedDetector):
    """Detector that reports a contact if four scores in a row, 0.4 ms apart, exceed a threshold.

    Frequent looks mean more chances of a false alarm. Two rules compensate for this: the lowest of
    the four scores must exceed the threshold, and the threshold is chosen on held-out pinches. All
    features are levels relative to the rig's noise while its motor runs. So the detector also works
    on rigs that it was not trained on.

    Parameters
    ----------
    seed
        Random seed of the training.
    """

    name: ClassVar[str] = "logistic"
    title: ClassVar[str] = "Logistic"
    colour: ClassVar[str] = GREEN
    step: ClassVar[float] = 0.0004
    lowest: ClassVar[float] = 1020.0
    duration: ClassVar[float] = 0.020 + (LOOKS - 1) * step
    reach: ClassVar[int] = 22
    _kernel: Any = None  # constants of the compiled kernel, for the rate of the stream

    def __init__(self, seed: int = 0) -> None:
        super().__init__(seed)
        self._line: NDArray[np.float64] | None = None
        self._weights = np.zeros((0, ORDER + 1))
        self._newest: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "_kernel"}

    @property
    def trained(self) -> bool:
        """True after training or loading."""
        return self._line is not None

    def fit(self, dataset: Dataset, early: float = 0.0) -> Self:
        """Learn from pinches with known first contacts, each from the start of its closing.

        Raises
        ------
        InputError
            Fewer than two pinches have a known first contact after enough quiet, or the rate is
            below :attr:`lowest`.
        """
        dataset = cut_closings(dataset)
        rate, sizes = self._window_sizes(dataset)
        subset = spread_out(dataset, sizes, early, PINCHES)
        rng = np.random.default_rng(self.seed)
        looks = [cut_looks(pinch, sizes, early, rng) for pinch in subset.pinches]
        has_contact = np.array([look.shows.any() for look in looks], dtype=np.bool_)
        if has_contact.sum() < 2:
            raise self._too_few(has_contact.sum())
        looks = [look for look in looks if look.shows.any()]
        groups = session_groups(subset.sessions[has_contact], FOLDS) % FOLDS
        levels = np.empty((len(looks), 2))
        for fold in np.unique(groups):
            line = fit_line(
                [look for look, g in zip(looks, groups, strict=True) if g != fold], self.seed
            )
            for place in np.flatnonzero(groups == fold):
                levels[place] = looks[place].levels(line)
        has_levels = np.isfinite(levels).all(axis=1)
        if has_levels.sum() < 2:
            raise self._too_few(has_levels.sum())
        self._line = fit_line(looks, self.seed)
        self._line[-1] -= best_threshold(levels[has_levels])
        self._rate = rate
        return self

    def settled(self, quiet: NDArray[np.float64]) -> None:
        """Fit the linear prediction of each channel's motor noise."""
        self._weights = np.stack([prediction(x) for x in quiet.T])
        self._newest = None
        self._kernel = self._compile()
        self._memory = np.full((len(self._weights), _REMEMBERED, 2), np.nan)

    def _compile(self) -> Any:
        """Return the constants of the compiled kernel; None if it cannot be used."""
        module, sizes = kernels(), self._sizes
        lengths = np.array(parts(self._rate), np.int32)
        # A subclass may judge in its own way.
        if module is None or type(self) is not LogisticDetector:
            return None
        try:
            return module.detector(
                sizes.window,
                sizes.step,
                LOOKS,
                self.reach * sizes.step,
                AWAKE,
                FLOOR,
                lengths,
                self._line,
            )
        except ValueError:  # windows are longer than the kernel's room
            return None

    def _judge_windows(
        self, state: SteadyState, ends: NDArray[np.int64]
    ) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
        module = kernels()
        if module is None or self._kernel is None:
            return super()._judge_windows(state, ends)
        onsets = np.empty((len(ends), len(self._fingers)), np.int32)
        module.judge(
            self._kernel,
            np.ascontiguousarray(self._past),
            self._past_first,
            int(ends[0]) - self._past_first,
            len(ends),
            state.mean,
            state.sigma,
            self._weights,
            np.array([finger not in self._latched for finger in self._fingers]),
            self._memory,
            onsets,
        )
        fired = onsets >= 0
        return fired, np.where(fired, onsets.astype(np.int64) + self._past_first, -1)

    def wakes(self, x: NDArray[np.float64], ends: NDArray[np.intp]) -> NDArray[np.bool_]:
        """Return a mask of the windows whose newest samples are loud on any finger."""
        step = self._sizes.step
        first = int(ends[0]) - step
        loud = np.abs(x[first:]).max(axis=1) > AWAKE
        # Windows follow each other by one step, so the new parts do not overlap.
        return np.asarray(loud[: len(ends) * step].reshape(-1, step).any(axis=1))

    def fires(self, windows: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return a mask of the windows whose last four looks all score above the threshold."""
        assert self._line is not None
        step = self._sizes.step
        length = windows.shape[2] - (LOOKS - 1) * step
        seen_scores = np.full((*windows.shape[:2], LOOKS), np.nan)
        # Windows that follow each other share looks: the newer ones of the earlier window.
        shared = (windows[1:, :, :-step] == windows[:-1, :, step:]).all(axis=2)
        if self._newest is not None:  # so does the newest window of the block before
            window, earlier_scores = self._newest
            is_next = (windows[0, :, :-step] == window[:, step:]).all(axis=1)
            seen_scores[0, :, :-1] = np.where(is_next[:, None], earlier_scores[:, 1:], np.nan)
        # A second detection of a finger would be ignored.
        above = np.tile(
            [finger not in self._latched for finger in self._fingers], (len(windows), 1)
        )
        for look in reversed(range(LOOKS)):
            if look + 1 < LOOKS:
                seen_scores[1:, :, look] = np.where(shared, seen_scores[:-1, :, look + 1], np.nan)
            rows, fingers = np.nonzero(above & np.isnan(seen_scores[:, :, look]))
            if len(rows):
                part = windows[rows, fingers, look * step : look * step + length]
                features = loudness_features(part, self._weights[fingers], self._rate)
                seen_scores[rows, fingers, look] = scores(features, self._line)
            above &= seen_scores[:, :, look] > 0.0
            if not above.any():
                break
        self._newest = windows[-1].copy(), seen_scores[-1].copy()
        return above

    def judgement(self, rate: float) -> Judgement:
        """Return the detector as a C kernel for export, which sums squares sample by sample."""
        self._require_training("there is nothing to export")
        assert self._line is not None
        sizes = self.sizes(rate)
        *lengths, recent = parts(rate)
        look = sizes.window - (LOOKS - 1) * sizes.step
        quiet, ring = look - recent, 1 << sizes.window.bit_length()
        line = logarithm_weights(self._line[:-1])
        constants: Constants = {
            "awake": AWAKE,
            "floor": FLOOR,
            "ridge": RIDGE,
            "bias": float(self._line[-1]),
            "doubt": ROUGH * float(np.abs(line).sum()),
            "recent": recent,
            "lengths": np.array(lengths, np.int32),
            "line": line.ravel(),
        }
        # Three peaks of the quiet part's steps, extremes of steps, and cumulative sums; then the
        # weights of the prediction and their input.
        steps = look // sizes.step - -(-recent // sizes.step)
        sums = 3 * (steps + 3) + 6 * (ring // min(sizes.step, 2)) + 4 * ring
        doubles = sums + 2 * ORDER + 1 + len(lengths) + 5 + 4 * LOOKS
        lengths_of = {"FC_LOOK": look, "FC_LOOKS": LOOKS, "FC_QUIET": quiet}
        return Judgement("loudness", constants, lengths_of, doubles)

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        """Return the rate, the weights, and the intercept from which the threshold is subtracted.

        Raises
        ------
        InputError
            The detector is not trained.
        """
        self._require_training("there is nothing to save")
        assert self._line is not None
        return {"line": self._line, "rate": np.asarray(self._rate)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Restore a detector from :meth:`to_arrays`.

        Raises
        ------
        InputError
            An array is missing, has a wrong shape or is not finite.
        """
        detector = cls()
        detector._line = stored_array(arrays, "line", (2 * EACH + 1,))
        detector._rate = float(stored_array(arrays, "rate", ()))
        if detector._rate < cls.lowest:
            raise InputError(
                f"the detector's sampling rate is below {cls.lowest:g} Hz: train it again"
            )
        return detector
