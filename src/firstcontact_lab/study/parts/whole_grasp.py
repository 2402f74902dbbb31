"""Study part ``whole_grasp``: errors while the hand closes.

It compares estimates from the first finger, the second finger and the squeeze.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Record
from firstcontact.core.display import BLUE, GREEN, INK, ORANGE, SKY
from firstcontact.jobs import Runner
from firstcontact.models.model_file import pretrained
from firstcontact.models.rig.combined import adapt_combined
from firstcontact.twin import CONDITIONS
from firstcontact_lab.report.findings import Figure, PartResult
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.style import banded_line, canvas, uri
from firstcontact_lab.report.tables import ABSENT, Cell, Line, Table
from firstcontact_lab.study.grasps import (
    LONGEST_GAP,
    SECOND,
    SQUEEZES,
    GraspLaw,
    Sizes,
    SqueezeScale,
    grasps,
)
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject, Subjects
from firstcontact_lab.study.random_rigs import EVERYDAY, OWN, RANDOM, RigScores, rig_scores
from firstcontact_lab.study.scores import predictions_by_time

T = TypeVar("T")
Values = NDArray[np.float64]
#: Times after the first contact of the estimates from the first finger, ms, and all times.
FIRST = (2, 3, 5, 8, 15)
TIMES = (*FIRST, 25, *SQUEEZES)
#: Seed of the first random hand that laws are measured on, and their number. None is scored.
LAW_SEED, LAW_HANDS = 9201, 12
METHODS = {
    "first": "First finger",
    "fingers": "Both fingers",
    "squeeze": "Squeeze (classical)",
    "sharpened": "All together",
    "exact": "Squeeze, exact sensors",
    "sharpened_exact": "All together, exact sensors",
}
_COLOURS = dict(zip(METHODS, (SKY, BLUE, ORANGE, GREEN, INK, INK), strict=True))
SCORES = ("rmse", "bias", "coverage", "width")
USES = (EVERYDAY, RANDOM)
KEYS = tuple(f"{use} {ms} {score}" for use in USES for ms in TIMES for score in SCORES)


class WholeGrasp(Record, frozen=True, kw_only=True):
    """Scores by method, and by use, time after the first contact (ms) and score."""

    seeds: list[int]
    pinches: dict[str, int]
    #: Share of the pinches without an estimate of both fingers and the squeeze, which are left out.
    left_out: float
    #: Mean time from the first contact to the estimate with the second finger, ms.
    second_ms: float
    #: Error of the squeeze on objects, Shore A, by the scale of the hand's blocks alone: its mean.
    softer: float
    #: Correlation of the errors of both fingers.
    correlation: float
    #: Laws by method and time, measured on random objects of other hands, and scores with them.
    laws: dict[str, GraspLaw]
    methods: dict[str, RigScores]
    #: The same for laws measured on random and everyday objects. Older results have none.
    pooled_laws: dict[str, GraspLaw] = msgspec.field(default_factory=dict)
    pooled: dict[str, RigScores] = msgspec.field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class _Estimates:
    """Estimates for the objects of one hand or several hands.

    ``first`` has (value, spread, low, high) from the first finger, shape (times, 4, objects).
    """

    first: Values
    second: Values
    #: Squeezes by the hand's sensors and by exact ones, relative to those of the hand's blocks,
    #: (times, inputs, n). The first input is the Shore A of a block with that stiffness.
    squeeze: Values
    exact: Values
    gaps: Values
    shore_a: Values
    uses: NDArray[np.str_]
    left_out: float

    def take(self, use: str) -> _Estimates:
        rows = self.uses == use
        cut: dict[str, Any] = {name: getattr(self, name)[..., rows] for name in _ARRAYS}
        return replace(self, **cut)

    def predict(
        self, name: str, ms: int, laws: Mapping[str, GraspLaw]
    ) -> tuple[Values, Values, Values]:
        """Return (values, low, high) of the method ``name``, ``ms`` after the first contact."""
        value, _, low, high = self.first[FIRST.index(ms) if ms in FIRST else -1]
        if name == "first":
            return value, low, high
        if ms not in SQUEEZES:
            name = "fingers"
        law = laws[name if name == "fingers" else f"{name} {ms}"]
        made = law.predict(*self.evidence(name, ms, laws))
        is_there = 1e3 * (self.gaps + SECOND) <= ms
        value, low, high = (
            np.where(is_there, *pair) for pair in zip(made, (value, low, high), strict=True)
        )
        return value, low, high

    def evidence(
        self, name: str, ms: int, laws: Mapping[str, GraspLaw]
    ) -> tuple[Values, Values, Values]:
        """Return (estimates, spreads, evidence), the inputs of a :class:`GraspLaw`."""
        if name in SENSORS:
            squeezes = getattr(self, name)[SQUEEZES.index(ms)].T
            return np.zeros(len(squeezes)), np.ones(len(squeezes)), squeezes
        first, spread = self.first[-1, :2]
        evidence = [self.second - first, self.gaps]
        if name != "fingers":
            classical = "exact" if name == "sharpened_exact" else "squeeze"
            evidence.append(self.predict(classical, ms, laws)[0] - first)
        return first, spread, np.column_stack(evidence)


_ARRAYS = ("first", "second", "squeeze", "exact", "gaps", "shore_a", "uses")
#: Classical methods. They have no estimate before ``SQUEEZES``.
SENSORS = ("squeeze", "exact")


def measure_laws(pinches: _Estimates) -> dict[str, GraspLaw]:
    """Measure how later evidence corrects the first finger's estimate, and classical methods."""
    laws: dict[str, GraspLaw] = {}
    given = pinches.evidence("fingers", SQUEEZES[-1], laws)
    laws["fingers"] = GraspLaw.measure(*given, pinches.shore_a, shifts=False)
    for name in (*SENSORS, "sharpened", "sharpened_exact"):
        for ms in SQUEEZES:
            given = pinches.evidence(name, ms, laws)
            law = GraspLaw.measure(*given, pinches.shore_a, shifts=name in SENSORS)
            laws[f"{name} {ms}"] = law
    return laws


def measure(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    if subject.name not in CONDITIONS:
        return PartResult()
    first, *others = settings.rig_seeds
    seeds = [first, *(others or [first + 1])]  # intervals need two hands
    hands = range(LAW_SEED, LAW_SEED + (4 if settings.brief else LAW_HANDS))
    sizes = Sizes(blocks=6, objects=1, random=8) if settings.brief else Sizes()
    jobs = [*((seed, False) for seed in seeds), *((seed, True) for seed in hands)]
    estimates = runner.map(_estimates, jobs, subject.name, sizes, settings.seed)
    scored = estimates[: len(seeds)]
    unscored = joined(estimates[len(seeds) :])
    random = unscored.take(RANDOM)
    laws, pooled_laws = measure_laws(random), measure_laws(unscored)
    rows = np.array([[_scores(each, used) for used in (laws, pooled_laws)] for each in scored])
    methods, pooled = (
        {name: _without_gaps(method) for name, method in zip(METHODS, scores, strict=True)}
        for scores in rig_scores(rows, KEYS, settings.seed)
    )
    del pooled["first"]  # it uses no law
    errors = [finger - random.shore_a for finger in (random.first[-1, 0], random.second)]
    results = WholeGrasp(
        seeds=seeds,
        pinches={use: sum(int((each.uses == use).sum()) for each in scored) for use in USES},
        left_out=float(np.mean([each.left_out for each in scored])),
        second_ms=1e3 * float(np.mean([each.gaps.mean() for each in scored]) + SECOND),
        softer=float(np.mean(random.squeeze[:, 0] - random.shore_a)),
        correlation=float(np.asarray(np.corrcoef(errors))[0, 1]),
        laws=laws,
        methods=methods,
        pooled_laws=pooled_laws,
        pooled=pooled,
    )
    return PartResult([WHOLE_GRASP(results)], [time_figure(results)])


def joined(estimates: Sequence[_Estimates]) -> _Estimates:
    """Return the estimates of several hands, concatenated over their objects."""
    arrays: dict[str, Any] = {
        name: np.concatenate([getattr(each, name) for each in estimates], axis=-1)
        for name in _ARRAYS
    }
    return replace(estimates[0], **arrays)


def _estimates(job: tuple[int, bool], condition: str, sizes: Sizes, seed: int) -> _Estimates:
    """Simulate a hand, calibrate it on its blocks, and return the estimates of other objects.

    ``job`` is the hand's seed, and True for a random hand.
    """
    hand, is_random = job
    pinches = grasps(hand, condition, sizes, is_random=is_random)
    own = pinches.uses == OWN
    shore_a, sessions = pinches.shore_a[own], pinches.sessions[own]

    first, second = (
        adapt_combined(pretrained(), touches.take(own), shore_a, sessions, seed).model
        for touches in (pinches.first, pinches.second)
    )
    by_time = predictions_by_time(first, pinches.first.take(~own), FIRST)
    squeeze, exact = (
        np.array([SqueezeScale.fit(at[own], shore_a).evidence(at[~own]) for at in features])
        for features in (pinches.squeezes, pinches.exact)
    )
    return _Estimates(
        np.array([[p.value, p.spread, p.low, p.high] for p in by_time.values()]),
        second.predict_touches(pinches.second.take(~own)).value,
        squeeze,
        exact,
        pinches.gaps[~own],
        pinches.shore_a[~own],
        pinches.uses[~own],
        pinches.left_out / (pinches.left_out + len(own)),
    )


def _scores(estimates: _Estimates, laws: Mapping[str, GraspLaw]) -> list[list[float]]:
    """Return the scores of a hand, as a list of ``KEYS`` for each method.

    In place of an RMSE, they have the mean squared error.
    """
    out: list[list[float]] = [[] for _ in METHODS]
    for use in USES:
        pinches = estimates.take(use)
        for ms in TIMES:
            for scores, name in zip(out, METHODS, strict=True):
                if name in SENSORS and ms not in SQUEEZES:
                    scores += [np.nan] * len(SCORES)
                    continue
                value, low, high = pinches.predict(name, ms, laws)
                errors = value - pinches.shore_a
                inside = (low <= pinches.shore_a) & (pinches.shore_a <= high)
                means = (errors**2, errors, inside, high - low)
                scores += [float(np.mean(each)) for each in means]
    return out


def _without_gaps(scores: RigScores) -> RigScores:
    """Return the scores without the times at which the method has no estimate."""
    there = [key for key, value in scores.scores.items() if np.isfinite(value)]

    def kept(values: dict[str, T]) -> dict[str, T]:
        return {key: values[key] for key in there}

    return RigScores(
        scores=kept(scores.scores), intervals=kept(scores.intervals), gains=kept(scores.gains)
    )


WHOLE_GRASP = Field.optional("whole_grasp", WholeGrasp)


def time_figure(results: WholeGrasp) -> Figure:
    """Return the figure of errors over time after the first contact."""
    drawn = {
        "fingers": ("o--", TIMES),
        "sharpened": ("o-", TIMES),
        "squeeze": ("s-", SQUEEZES),
        "exact": ("s:", SQUEEZES),
    }
    titles = {EVERYDAY: "Everyday objects", RANDOM: "Random objects"}
    with canvas(1, 2, (7.6, 3.9), sharey=True) as (figure, axes):
        for ax, (use, title) in zip(axes[0], titles.items(), strict=True):
            for name, (style, times) in drawn.items():
                scores = results.methods[name]
                keys = [f"{use} {ms} rmse" for ms in times]
                values = [scores.scores[key] for key in keys]
                ends = [scores.intervals[key] for key in keys]
                banded_line(ax, times, values, ends, style, _COLOURS[name], METHODS[name])
            ax.axvline(results.second_ms, color=INK, lw=0.8, ls=":")
            ax.set(title=title, xscale="log", xlabel="Time after the first contact (ms)")
            ax.set_xticks(_TICKS, [f"{ms}" for ms in _TICKS])
            ax.minorticks_off()
        axes[0, 0].set(ylabel="RMSE (Shore A)", ylim=(0, None))
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        image = uri(figure)
    return Figure(
        "whole_grasp",
        "Error while the hand closes",
        "One estimate that sharpens, and the classical stiffness of the squeeze, all on the same "
        f"pinches: those whose second finger touches 2 to {1e3 * LONGEST_GAP:.0f} ms after the "
        f"first. Simulated hands; bands are 95 % bootstrap intervals over {len(results.seeds)} "
        "hands. The dotted line is the mean time of the estimate with the second finger.",
        image,
    )


_TICKS = (2, 5, 15, 50, 100, 200, 500)
_UNITS = {"rmse": "shore", "bias": "bias", "coverage": "share", "width": "shore"}
_LINES = (
    ("first", (2, 5, 15)),
    ("fingers", (100,)),
    ("squeeze", (SQUEEZES[0], SQUEEZES[-1])),
    ("sharpened", (SQUEEZES[0], SQUEEZES[-1])),
    ("exact", SQUEEZES[-1:]),
    ("sharpened_exact", SQUEEZES[-1:]),
)


def _table(results: SubjectResults, use: str, title: str) -> Table | None:
    grasp = results[WHOLE_GRASP]
    if grasp is None:
        return None
    caption = (
        f"{title}, by the evidence that is used: {grasp.pinches[use]:,} pinches of "
        f"{len(grasp.seeds)} simulated hands with specimens of their own (seeds "
        f"{', '.join(map(str, grasp.seeds))}). After each value: its 95 % bootstrap interval over "
        "hands; in brackets that of the difference from the first finger at the same time. All "
        "methods on the same pinches, without those in which the second finger touches within 2 ms "
        f"or after {1e3 * LONGEST_GAP:.0f} ms ({100 * grasp.left_out:.0f} %). Weights are fitted "
        "to random objects of other hands, pooled ones to random and everyday objects."
    )
    lines = []
    shown = [(grasp.methods, "", name, ms) for name, times in _LINES for ms in times]
    shown += [(grasp.pooled, " (pooled)", name, SQUEEZES[-1]) for name in grasp.pooled]
    for methods, law, name, ms in shown:
        when = f"{grasp.second_ms:.0f} ms on average" if name == "fingers" else f"{ms} ms"
        scores = methods[name]
        cells = [scores.cell(f"{use} {ms} {key}", unit) for key, unit in _UNITS.items()]
        if any(cell.text != ABSENT for cell in cells):
            lines.append(Line([Cell(f"{METHODS[name]}, {when}{law}"), *cells]))
    return Table(caption, ["", "RMSE", "Bias", "Coverage", "Width"], lines)


def _text(subjects: Subjects) -> str:
    text = (
        "The first finger's estimates are those of the shipped model, adapted to blocks. The "
        f"second finger's first {1e3 * SECOND:.0f} ms are predicted by the same network, adapted "
        "to second contacts on blocks. The classical method measures the stiffness of the squeeze "
        "from the force cells and the travel of the drives (200 positions a second with an error "
        "of 0.1 mm), calibrated on the same blocks. “Exact sensors” have the true force and "
        "compression at the fingertips. Weights are fitted on random objects of other, random "
        "hands: for the classical method those of a linear regression from the squeeze, relative "
        "to those of the hand's blocks, to Shore A; for the average those of second finger, time "
        "between the contacts and squeeze. Pooled weights are fitted on random and everyday "
        "objects of these hands."
    )
    for results in subjects.values():
        if (grasp := results[WHOLE_GRASP]) is not None:
            return (
                f"{text} The errors of both fingers correlate by {grasp.correlation:.2f}, and the "
                f"second finger gets the weight {grasp.laws['fingers'].weights[0]:.2f}. By the "
                f"blocks alone the squeeze reads these objects {-grasp.softer:.0f} Shore A too "
                "soft, because their shape and structure yield, too."
            )
    return text


PART = Part(
    "whole_grasp",
    "The whole grasp",
    [Step("the whole grasp", measure, late=True, cost=60)],
    _text,
    [
        lambda results: _table(results, EVERYDAY, "Everyday objects"),
        lambda results: _table(results, RANDOM, "Random objects"),
    ],
    needs=(),
)
