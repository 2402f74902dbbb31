"""Contact detector: a logistic regression on the loudness of the signal.

It scores a window, called a look, every 0.4 ms. Four consecutive looks must agree.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from firstcontact.chain.constants import DetectorConstants, DetectorKind
from firstcontact.chain.image import RESETTLED, SETTLED
from firstcontact.chain.touch import fit_predictions, look_features
from firstcontact.contact.closing_start import cut_closings
from firstcontact.contact.detector import TrainedDetector, WindowSizes, spread_out, stored_array
from firstcontact.contact.training import SteadyState, session_groups
from firstcontact.core import Dataset, ModelError, Pinch
from firstcontact.core.display import GREEN
from firstcontact.core.installation import require_modules
from firstcontact.signal import DeviceSmoothing, samples_in

#: Lengths of the newest parts, s: from two samples to three milliseconds.
PARTS = (0.0004, 0.0008, 0.0014, 0.0022, 0.003)
#: Length of the recent part at the end of a window, s. The rest is the quiet part.
RECENT = 0.006
#: Order of the linear prediction.
ORDER = 12
#: Added to a level, in sigmas, before its logarithm. Smaller levels do not matter.
FLOOR = 0.1
#: Number of features of the signal, and of its prediction error.
EACH = len(PARTS) + 3


def parts(rate: float) -> list[int]:
    """Return the lengths of the spans at a window's end whose loudness is a feature, in samples.

    ``rate`` is in Hz.
    """
    lengths: list[int] = []
    for part in (*PARTS, RECENT):
        lengths.append(max(samples_in(part, rate), lengths[-1] + 1 if lengths else 1))
    return lengths


#: Number of consecutive looks that must agree: 1.2 ms, longer than most clicks.
LOOKS = 4
#: In training, a look must show a contact whose age is between these, s.
YOUNGEST, OLDEST = 0.0008, 0.0030
#: Latest age of a contact at which its detection counts as in time, s.
DUE = 0.0026
#: Clicks added to a channel of a pinch of average length: their mean number, their median peak in
#: sigmas of the prediction error, their longest duration in samples, and the share of the ringing
#: that remains after each sample.
CLICKS = 4.0
CLICK = 8.0
CLICK_LENGTH = 5
DAMPED = 0.9
#: Largest number of looks per class in training.
MOST = 40_000


@dataclass(frozen=True, slots=True, eq=False)
class Looks:
    """Features of all looks (windows) in one pinch, finger by finger, with masks of shape (looks,).

    ``quiet`` marks looks before their finger's contact, ``shows`` looks that show it, ``early``
    looks before the pinch's first contact, and ``due`` looks at which its detection is in time.
    ``begins`` holds the first row of each finger.
    """

    features: NDArray[np.float64]
    quiet: NDArray[np.bool_]
    shows: NDArray[np.bool_]
    early: NDArray[np.bool_]
    due: NDArray[np.bool_]
    begins: tuple[int, ...]

    def levels(self, line: NDArray[np.float64]) -> tuple[float, float]:
        """Return the highest score before the first contact, and the highest one soon after it.

        A score is the least of four consecutive looks. ``line`` holds weights, then the intercept.
        """
        score = scores(self.features, line)
        agreed = np.full(len(score), -np.inf)
        for a, b in zip(self.begins[:-1], self.begins[1:], strict=True):
            if b - a >= LOOKS:
                agreed[a + LOOKS - 1 : b] = sliding_window_view(score[a:b], LOOKS).min(axis=1)
        return (
            float(agreed[self.early].max(initial=-np.inf)),
            float(agreed[self.due].max(initial=-np.inf)),
        )


def add_clicks(
    x: NDArray[np.float64], weights: NDArray[np.float64], stop: int, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return one channel with random clicks added, which resemble clicks of this hand's gears.

    ``weights`` predict the noise of the motor. Clicks start before the sample ``stop``.
    """
    burst = np.zeros(len(x))
    for start in rng.integers(0, max(1, stop), rng.poisson(CLICKS * stop / len(x))):
        length = int(rng.integers(1, CLICK_LENGTH + 1))
        peak = CLICK * math.exp(0.5 * rng.standard_normal()) * rng.choice((-1.0, 1.0))
        shape = peak * np.sin(np.pi * (np.arange(length) + 0.5) / length)
        burst[start : start + length] += shape[: len(x) - start]
    if not weights[0] > 0.0:
        return x
    from scipy.signal import lfilter  # slow to import, and a trained detector does not need it

    rung: NDArray[np.float64] = lfilter([1.0], weights * DAMPED ** np.arange(ORDER + 1), burst)
    return x + rung


def cut_looks(pinch: Pinch, sizes: WindowSizes, early: float, rng: np.random.Generator) -> Looks:
    """Return the looks of a pinch whose first contact is labelled, with random clicks added."""
    layout, rate = pinch.layout, pinch.layout.rate
    smooth = DeviceSmoothing(layout).update(pinch.vibration())
    steady = SteadyState.measure(smooth[: sizes.steady])
    margin = samples_in(early, rate)
    first = pinch.truth[0].sample - pinch.first_sample
    length = sizes.window - (LOOKS - 1) * sizes.step
    lengths = parts(rate)
    rows = []
    for column, finger in enumerate(layout.vibration_fingers):
        if not steady.alive[column]:
            continue
        x = steady.normalise(smooth)[:, column]
        (ringing,) = fit_predictions(x[None, : sizes.steady])
        contacts_of_finger = [
            c.sample - pinch.first_sample for c in pinch.truth if c.finger is finger
        ][:1]
        contact = (contacts_of_finger or [first])[0]
        oldest = samples_in(OLDEST, rate) if contacts_of_finger else -margin
        stop = min(len(x), contact + oldest)
        x = add_clicks(x, ringing, contact - samples_in(0.02, rate), rng)
        ends = np.arange(sizes.steady + sizes.step, stop + 1, sizes.step)
        windows = sliding_window_view(x, length)[ends - length]
        age = ends - contact
        is_first = contacts_of_finger == [first]
        # A program on the hand keeps the first steady state.
        for last in (0, len(x)):
            rows.append(
                (
                    look_features(
                        *_normalise(windows, x, ends, sizes.steady, last, rate), lengths, FLOOR
                    ),
                    age <= -margin,
                    (age >= samples_in(YOUNGEST, rate)) & bool(contacts_of_finger),
                    ends <= first - margin,
                    (age > 0) & (age <= samples_in(DUE, rate)) & is_first,
                )
            )
    empty = (np.zeros((0, 2 * EACH)), *(np.zeros(0, np.bool_) for _ in range(4)))
    combined = [np.concatenate(kind) for kind in zip(empty, *rows, strict=True)]
    begins = np.cumsum([0, *(len(row[0]) for row in rows)]).tolist()
    features, quiet, shows, early_looks, due = combined
    return Looks(features, quiet, shows, early_looks, due, tuple(begins))


def _normalise(
    windows: NDArray[np.float64],
    x: NDArray[np.float64],
    ends: NDArray[np.intp],
    steady: int,
    last: int,
    rate: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Divide windows by the standard deviation of the motor's noise, after subtracting its mean.

    Return these windows, and for each the filter that predicts the noise, shape (n, ORDER + 1).
    ``x`` is the whole channel, and ``ends`` holds the end of each window in it. The noise is
    measured in the first ``steady`` samples, as in the chain. It is measured again whenever it has
    become weaker, before the sample ``last``.
    """
    every, age = samples_in(RESETTLED, rate), samples_in(SETTLED, rate)
    state = SteadyState.measure(x[:steady, None])
    (ringing,) = fit_predictions(state.normalise(x[:steady, None]).T)
    out, weights = np.empty(windows.shape), np.empty((len(ends), ORDER + 1))
    for begin in range(0, int(ends[-1]) if len(ends) else 0, every):
        quiet = x[max(begin - age - steady, 0) : max(begin - age, 0), None]
        later = SteadyState.measure(quiet) if begin < last and len(quiet) == steady else state
        if state.is_louder_than(later)[0]:
            state = later
            (ringing,) = fit_predictions(state.normalise(quiet).T)
        rows = (ends > begin) & (ends <= begin + every)
        out[rows] = state.normalise(windows[rows, :, None])[..., 0]
        weights[rows] = ringing
    return out, weights


def scores(features: NDArray[np.float64], line: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a score per look, shape (looks,). A positive score means a contact.

    ``line`` holds weights, then the intercept.
    """
    # A matrix product would round differently for other numbers of rows.
    out: NDArray[np.float64] = (features * line[:-1]).sum(axis=1) + line[-1]
    return out


def fit_line(looks: Sequence[Looks], seed: int) -> NDArray[np.float64]:
    """Fit a logistic regression with balanced classes. Return weights, then the intercept."""
    require_modules("train", "sklearn")
    from sklearn.linear_model import LogisticRegression

    rng = np.random.default_rng(seed)
    quiet = np.concatenate([look.features[look.quiet] for look in looks])
    loud = np.concatenate([look.features[look.shows] for look in looks])
    quiet, loud = (x[rng.permutation(len(x))[:MOST]] for x in (quiet, loud))
    x = np.concatenate([quiet, loud])
    mean, scale = x.mean(axis=0), x.std(axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    machine = LogisticRegression(class_weight="balanced", max_iter=1000)
    machine.fit((x - mean) / scale, np.arange(len(x)) >= len(quiet))
    weights = machine.coef_[0] / scale
    return np.append(weights, machine.intercept_[0] - weights @ mean)


def best_threshold(levels: NDArray[np.float64]) -> float:
    """Return the threshold on scores with the fewest false alarms and late decisions.

    ``levels`` holds the result of :meth:`Looks.levels` for each pinch, shape (pinches, 2).
    """
    quiet, loud = levels.T
    candidates = np.linspace(quiet.min(), max(loud.max(), quiet.max()), 1001)

    def wrong(x: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(0.5 * (1.0 + np.tanh(x / 2.0)).sum(axis=0))

    cost = wrong(quiet[:, None] - candidates) + wrong(candidates - loud[:, None])
    return float(candidates[np.argmin(cost)])


#: Least deviation of a new sample, in sigmas, for which a window is evaluated.
AWAKE = 3.0
#: Largest number of training pinches, and number of folds for the threshold.
PINCHES = 1000
FOLDS = 3


class LogisticDetector(TrainedDetector):
    """Detector that reports a contact if four scores in a row, 0.4 ms apart, exceed a threshold."""

    name: ClassVar[str] = "logistic"
    title: ClassVar[str] = "Logistic"
    colour: ClassVar[str] = GREEN
    step: ClassVar[float] = 0.0004
    lowest: ClassVar[float] = 1020.0
    duration: ClassVar[float] = 0.020 + (LOOKS - 1) * step
    reach: ClassVar[int] = 22

    def __init__(self, seed: int = 0) -> None:
        super().__init__(seed)
        self._line: NDArray[np.float64] | None = None

    @property
    def trained(self) -> bool:
        return self._line is not None

    def fit(self, dataset: Dataset, early: float = 0.0) -> Self:
        """Train on pinches with known first contacts, from where the hand starts to close."""
        dataset = cut_closings(dataset)
        rate, sizes = self._window_sizes(dataset)
        subset = spread_out(dataset, sizes, early, PINCHES)
        rng = np.random.default_rng(self.seed)
        looks = [cut_looks(pinch, sizes, early, rng) for pinch in subset.pinches]
        has_contact = np.array([look.shows.any() for look in looks], dtype=np.bool_)
        looks = [look for look in looks if look.shows.any()]
        if len(looks) < 2:
            raise self._too_few(len(looks))
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

    def chain_constants(self, rate: float) -> DetectorConstants:
        self._check_rate(rate)
        return self._constants(
            rate,
            DetectorKind.LOGISTIC,
            looks=LOOKS,
            lengths=parts(rate),
            threshold=AWAKE,
            floor=FLOOR,
            line=self._line,
        )

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        """Return the sampling rate, and weights with the intercept minus the threshold."""
        self._require_training("there is nothing to save")
        assert self._line is not None
        return {"line": self._line, "rate": np.asarray(self._rate)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        detector = cls()
        detector._line = stored_array(arrays, "line", (2 * EACH + 1,))
        detector._rate = float(stored_array(arrays, "rate", ()))
        if detector._rate < cls.lowest:
            raise ModelError(
                f"the detector's sampling rate is {detector._rate:g} Hz, but must be "
                f"{cls.lowest:g} Hz or more: train it on recordings with a higher rate"
            )
        return detector
