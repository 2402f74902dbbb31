"""Estimator that adapts the pre-trained network to a rig. A summary of the rig becomes an input."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, floor
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ArgumentError, Finger
from firstcontact.core.display import GREEN
from firstcontact.core.text import counted, percent
from firstcontact.models.anytime import AnytimeModel
from firstcontact.models.card import TrainingRecord
from firstcontact.models.estimator import AnytimeEstimator
from firstcontact.models.model_file import pretrained
from firstcontact.models.registry import ESTIMATORS
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.rig.rigs import Rig
from firstcontact.models.splits import inner_folds
from firstcontact.models.touches import Touches
from firstcontact.models.values import Values
from firstcontact.signal import samples_in

#: Smallest number of pinches with which a finger is a rig of its own. With 15 of each finger, all
#: fingers as one rig predict objects better, by 0.2 Shore A at 5 ms; with 50, each finger alone, by
#: 0.3 (12 rigs). No choice by held-out blocks: it cost up to 2 Shore A on objects.
LEAST_OF_FINGER = 20
#: Largest number of pinches of a level of Shore A. The network was trained with about this many. On
#: held-out sessions, twenty-five times as many gave equal scores.
MOST_OF_LEVEL = 20
#: Middle of the scale, to which noise draws predictions, Shore A; smallest number of levels for a
#: rig's offset; least variance of a level's mean error; and standard deviation of offsets. Rigs of
#: other structure had a deviation of 1.8 on their blocks. 1 loses nothing on their objects.
MIDDLE, LEAST_LEVELS_OF_LINE, LEAST_VARIANCE, BIAS = 40.0, 4, 1.0, 1.0
#: Smallest factor of an average's intervals, even for a rig without errors on blocks. Small errors
#: on blocks do not mean small errors on other objects.
NARROWEST = 0.7
#: Number of folds in which pinches are held out.
FOLDS = 3


@dataclass(frozen=True, slots=True, eq=False)
class Adapted:
    """Model that was adapted to a rig, with its scores on held-out pinches.

    ``scores`` holds the RMSE of each kind of model, Shore A, and ``mean_rmse`` that of always
    predicting the mean. ``notes`` and ``split`` are sentences for the user.
    """

    model: RigModel
    scores: Mapping[str, float]
    mean_rmse: float = float("nan")
    check: IntervalCheck | None = None
    notes: tuple[str, ...] = ()
    split: str = ""

    @property
    def rmse(self) -> float:
        """RMSE of the model on held-out pinches, Shore A; NaN if none could be held out."""
        alone = self.scores.get(RigModel.kind, float("nan"))
        return self.scores.get(self.model.name, alone)

    @property
    def by_finger(self) -> bool:
        """True if each finger is a separate rig, False if all fingers are one rig."""
        return len(self.model.rigs) > 1

    @property
    def why_useless(self) -> str:
        """Reason why the model must not be used for this rig, as a sentence; "" if it is useful."""
        if not self.scores:
            return ""
        rmse = max(self.rmse, self.scores[RigModel.kind])
        if rmse < self.mean_rmse:
            return ""
        return (
            f"on held-out pinches the RMSE is {rmse:.1f} Shore A, and always predicting their mean "
            f"scores {self.mean_rmse:.1f}: the model does not work for this rig. Check the Shore A "
            "labels, the contacts, and that the sensor touches objects as a fingertip does, or use "
            "`firstcontact train`"
        )


@dataclass(frozen=True, slots=True, eq=False)
class IntervalCheck:
    """Coverage of a model's intervals on held-out pinches of the rig, and factors of widths."""

    n: int
    coverage: float
    scales: NDArray[np.float64]


def adapt_network(
    base: RigModel,
    touches: Touches,
    shore_a: Values,
    sessions: NDArray[np.str_] | None = None,
    seed: int = 0,
) -> Adapted:
    """Adapt the pre-trained network ``base`` to a rig, and score it on held-out pinches.

    Objects of unknown shape count as flat blocks. ``sessions`` are held out as a whole, if given.
    Raise ArgumentError with fewer than 4 pinches or 2 values of Shore A.
    """
    lasting, touches = touches.answerable, touches.as_blocks()
    longest, shore_a = touches.take(lasting), shore_a[lasting]
    sessions = None if sessions is None else sessions[lasting]
    if len(np.unique(shore_a)) < 2 or len(longest) < 4:
        raise ArgumentError(
            "the network needs at least 4 pinches and 2 values of Shore A, but the recordings have "
            f"{len(longest)} and {len(np.unique(shore_a))}: record pinches of more flat blocks"
        )

    def condition(touches: Touches, shore_a: Values) -> RigModel:
        rigs = known_rigs(touches, shore_a, seed)
        return base.conditioned_on({finger: rig for finger, (rig, _) in rigs.items()})

    held_out = score_held_out(condition, longest, shore_a, sessions, seed)
    if held_out is None:
        made = adapt_network(base, longest, shore_a, None, seed)
        return replace(
            made,
            split="random pinches were held out, because each session has one value of Shore A",
        )
    check = held_out.check(base.level, touches.rate)
    model = condition(longest, shore_a).rescaled(check.scales)
    scores = {model.name: root_mean_square(held_out.errors[-1])}
    return Adapted(model, scores, root_mean_square(held_out.from_mean), check)


#: Function from contacts and their Shore A to a model of the rig.
Condition = Callable[[Touches, Values], RigModel]


def known_rigs(
    touches: Touches, shore_a: Values, seed: int
) -> dict[int, tuple[Rig, NDArray[np.intp]]]:
    """Return a summary of the whole hand, and of each finger with enough pinches.

    Keys are finger numbers; -1 is the whole hand. Each value is the summary, and the positions of
    the contacts that it was computed from.
    """

    def rig(members: NDArray[np.intp]) -> tuple[Rig, NDArray[np.intp]]:
        chosen = members[_choose_pinches(shore_a[members], seed)]
        return Rig.fit(touches.take(chosen), shore_a[chosen]), chosen

    rigs = {Rig.ANY: rig(np.arange(len(touches)))}
    for finger in range(len(Finger)):
        positions = np.flatnonzero(touches.fingers == finger)
        if len(positions) >= LEAST_OF_FINGER and len(np.unique(shore_a[positions])) > 1:
            rigs[finger] = rig(positions)
    return rigs


def _choose_pinches(shore_a: Values, seed: int) -> NDArray[np.intp]:
    """Return ascending indices of pinches: at most ``MOST_OF_LEVEL`` random ones per Shore A."""
    rng = np.random.default_rng(seed)
    chosen = []
    for level in np.unique(shore_a):
        positions = np.flatnonzero(shore_a == level)
        chosen.append(rng.permutation(positions)[:MOST_OF_LEVEL])
    return np.sort(np.concatenate(chosen))


@dataclass(frozen=True, slots=True, eq=False)
class HeldOut:
    """Errors of predictions for held-out pinches of a rig, Shore A.

    Errors are predictions minus labels. ``from_mean`` are the errors of predicting the mean, shape
    (n,). ``rows`` are the positions of the pinches.
    """

    #: Errors at each scored time, shape (times, n). The last time is the longest.
    errors: Values
    from_mean: Values
    #: Half widths of the intervals, Shore A, shape (times, n).
    halves: Values
    #: Indices of the pinches, shape (n,).
    rows: NDArray[np.intp]

    def check(self, level: float, rate: float, is_average: bool = False) -> IntervalCheck:
        """Check the intervals by split conformal prediction at each time (Lei et al. 2018).

        Intervals of the network alone only become wider. Those of an average also become narrower,
        but stay wider than held-out blocks need, because other objects differ more.
        """
        n = len(self.rows)
        rank = min(ceil((n + 1) * level), n)
        ratios = np.abs(self.errors) / self.halves
        needed = np.sort(ratios, axis=1)[:, rank - 1]
        factors = np.hypot(needed, NARROWEST) if is_average else np.maximum(needed, 1.0)
        scales = np.interp(Rig.STAGES, Rig.stages_at_scored_times(rate), factors)
        return IntervalCheck(n, float((ratios <= 1).mean(axis=1).min()), scales)

    def offset(self, shore_a: Values, rate: float) -> NDArray[np.float64]:
        """Return the bias to subtract from predictions for the rig, Shore A, (signal lengths,).

        A line is fitted to the mean errors over the Shore A of the rig's blocks. The bias is its
        value at ``MIDDLE``, because noise draws predictions to the middle, which is no bias. The
        bias is shrunk to 0, and more so the worse the line fits.
        """
        bias = self._bias(shore_a[self.rows], LEAST_LEVELS_OF_LINE)
        return np.interp(Rig.STAGES, Rig.stages_at_scored_times(rate), bias)

    def less_offset(self, shore_a: Values) -> HeldOut:
        """Return the errors after subtracting the offset, which is cross-fitted.

        For the pinches of one Shore A, the offset is computed from the pinches of the other values.
        """
        truth, errors = shore_a[self.rows], self.errors.copy()
        levels = np.unique(truth)
        for level in levels if len(levels) >= LEAST_LEVELS_OF_LINE else ():
            others = replace(self, errors=self.errors[:, truth != level])
            bias = others._bias(truth[truth != level], LEAST_LEVELS_OF_LINE - 1)
            errors[:, truth == level] -= bias[:, None]
        return replace(self, errors=errors)

    def _bias(self, truth: Values, least_levels: int) -> NDArray[np.float64]:
        """Return the bias of the predictions, Shore A, at each scored time after a contact.

        It is the value in the middle of the scale of a line that is fitted to the mean errors, and
        is reduced if uncertain. ``truth`` holds the Shore A of each pinch. With fewer than
        ``least_levels`` different values, the bias is 0.
        """
        levels = np.unique(truth)
        if len(levels) < least_levels:
            return np.zeros(len(self.errors))
        means = np.stack([self.errors[:, truth == level].mean(axis=1) for level in levels])
        line = np.stack([np.ones(len(levels)), levels - MIDDLE], axis=1)
        fitted = np.linalg.lstsq(line, means)[0]
        left = np.square(means - line @ fitted).sum(axis=0) / (len(levels) - 2)
        variance = np.maximum(left, LEAST_VARIANCE) * np.linalg.inv(line.T @ line)[0, 0]
        out: NDArray[np.float64] = fitted[0] / (1.0 + variance / BIAS**2)
        return out


def score_held_out(
    condition: Condition,
    touches: Touches,
    shore_a: Values,
    sessions: NDArray[np.str_] | None,
    seed: int,
) -> HeldOut | None:
    """Return the errors on pinches that the model was not adapted to; None if none can be held out.

    ``condition`` makes the model from the other pinches of each fold.
    """
    parts = []
    for learn, ask in inner_folds(shore_a, sessions, seed, FOLDS):
        if len(np.unique(shore_a[learn])) < 2 or not len(ask):
            continue
        model = condition(touches.take(learn), shore_a[learn])
        test_touches, truth = touches.take(ask), shore_a[ask]
        errors, halves = [], []
        for ms in Touches.SCORED_MS:
            early = test_touches.until(samples_in(1e-3 * ms, touches.rate))
            predictions = model.predict_touches(early)
            halves.append(model.half_widths(predictions.spread, early.valid))
            errors.append(predictions.value - truth)
        from_mean = shore_a[learn].mean() - truth
        parts.append((np.array(errors), from_mean, np.array(halves), ask))
    if not parts:
        return None
    return HeldOut(*(np.concatenate(arrays, axis=-1) for arrays in zip(*parts, strict=True)))


def root_mean_square(errors: Values) -> float:
    return float(np.sqrt(np.mean(errors**2)))


@dataclass(frozen=True)
class NetworkEstimator(AnytimeEstimator):
    """Estimator that adapts the package's network to one rig (hand with its sensors).

    It learns from contacts with their whole signals instead of windows. No weights are trained: a
    summary of the rig's pinches becomes an input of the network.
    """

    name: ClassVar[str] = RigModel.kind
    title: ClassVar[str] = "Network"
    colour: ClassVar[str] = GREEN
    model: ClassVar[Any] = RigModel
    #: Function that conditions a network on the contacts of a rig, such as :func:`adapt_network`.
    adapt: ClassVar[Callable[..., Adapted]] = staticmethod(adapt_network)

    def fit(
        self,
        touches: Touches,
        shore_a: Values,
        sessions: NDArray[np.str_] | None = None,
        seed: int = 0,
    ) -> tuple[AnytimeModel, Sequence[str]]:
        made = self.adapt(pretrained(), touches, shore_a, sessions, seed)
        if made.why_useless:
            raise ArgumentError(made.why_useless)
        usable = touches.take(touches.answerable)
        record = TrainingRecord(pinches=len(usable), scores=_held_out_scores(made))
        return made.model.with_record(record), [
            _rig_sentence(shore_a[touches.answerable], made),
            *_speed_sentences(usable, made),
            *made.notes,
            *_check_sentences(pretrained(), made),
        ]


def rig_estimators() -> dict[str, type[NetworkEstimator]]:
    """Return the registered estimators that adapt the network to a rig. Keys are their names."""
    return {n: entry for n, entry in ESTIMATORS.items() if issubclass(entry, NetworkEstimator)}


def _rig_sentence(shore_a: Values, made: Adapted) -> str:
    """Return a sentence that states how many pinches the network was adapted to."""
    levels, counts = np.unique(shore_a, return_counts=True)
    per = " and finger" if made.by_finger else ""
    limit = f"; at most {MOST_OF_LEVEL} of each level{per} are used"
    return (
        f"the network was adapted to {counted(len(shore_a), 'pinch')} of "
        f"{counted(len(levels), 'Shore A level')}{limit * bool(counts.max() > MOST_OF_LEVEL)}"
    )


def _speed_sentences(touches: Touches, made: Adapted) -> list[str]:
    """Return a sentence on how the model uses measured closing speeds; [] if none was measured."""
    is_measured = np.isfinite(touches.speeds)
    if not is_measured.any():
        return []
    pinches = counted(int(is_measured.sum()), "pinch")
    error = f"{percent(root_mean_square(np.nan_to_num(touches.speed_errors[is_measured])))} error"
    speeds = made.model.rigs[Rig.ANY].speeds
    if speeds is None:
        return [
            f"closing speeds were measured in {pinches} ({error}) and are not used: their "
            "errors are too large compared with the differences of the speeds"
        ]
    return [
        f"closing speeds were measured in {pinches} ({error}); the model uses them: they differ "
        f"by {percent(speeds.spread)}"
    ]


def _held_out_scores(made: Adapted) -> dict[str, float]:
    scores = {f"held out, {kind}": score for kind, score in made.scores.items()}
    if made.check is not None:
        scores["held out, always the mean"] = made.mean_rmse
        scores["held out, least coverage"] = made.check.coverage
        scores["largest factor of widths"] = float(made.check.scales.max())
    return {name: round(score, 3) for name, score in scores.items()}


def _check_sentences(base: RigModel, made: Adapted) -> list[str]:
    """Return sentences for the user: errors on held-out pinches, and coverage of intervals."""
    if made.check is None:
        return ["errors and intervals were not checked, because there are too few pinches"]
    alone = made.scores[RigModel.kind]
    fingers = "each finger separately" if made.by_finger else "all fingers together"
    sentences = [made.split] if made.split else []
    sentences.append(
        f"on held-out pinches, the network has an rmse of {alone:.2f} Shore A, and always "
        f"predicting the mean has {made.mean_rmse:.2f}; it was adapted to {fingers}"
    )
    if (kind := made.model.name) != RigModel.kind:
        advice = (
            f"; the network alone had a lower error ({alone:.2f}): make the model with `train ... "
            "--estimator network`, or use `live --estimator network`"
        ) * (made.rmse > alone)
        sentences.append(f"{kind}, on the same pinches: rmse {made.rmse:.2f} Shore A{advice}")
    narrowest, widest = made.check.scales.min(), made.check.scales.max()
    change = (
        f"and all widths were then multiplied by {floor(100 * narrowest) / 100:.2f} to "
        f"{ceil(100 * widest) / 100:.2f}"
        if (made.check.scales != 1.0).any()
        else "and they were not changed"
    )
    least = floor(1000 * made.check.coverage + 1e-6) / 1000  # a share that is not too large
    sentences.append(
        f"at every time, the intervals contained the true Shore A of at least {percent(least)} of "
        f"{counted(made.check.n, 'held-out pinch')}; the nominal coverage is "
        f"{100 * base.level:.0f} %, {change}"
    )
    return sentences
