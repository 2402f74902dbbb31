"""Errors of estimates while the hand closes: first finger, second finger and squeeze."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

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
    EVERYDAY,
    OWN,
    RANDOM,
    SECOND,
    SQUEEZES,
    GraspLaw,
    Sizes,
    SqueezeScale,
    grasps,
)
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject, Subjects
from firstcontact_lab.study.random_rigs import RigScores, rig_scores
from firstcontact_lab.study.scores import NORMAL, predictions_by_time

T = TypeVar("T")
Values = NDArray[np.float64]
#: Times after the first contact of the estimates from the first finger, ms, and all times.
FIRST = (2, 3, 5, 8, 15)
TIMES = (*FIRST, 25, *SQUEEZES)
#: Seed of the first random hand that the law is measured on, and their number. None is scored.
LAW_SEED, LAW_HANDS = 9201, 12
#: Time of the squeeze at which the law is measured, ms.
SETTLED = 200
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
    too_short: float
    #: Mean time from the first contact to the estimate with the second finger, ms.
    second_ms: float
    law: GraspLaw
    methods: dict[str, RigScores]


@dataclass(frozen=True, slots=True, eq=False)
class _Estimates:
    """Estimates for the objects of one hand: value, spread, low and high, (times, 4, n)."""

    first: Values
    #: Values and spreads, (times, 2, n); NaN without an estimate.
    second: Values
    squeeze: Values
    exact: Values
    gaps: Values
    shore_a: Values
    uses: NDArray[np.str_]
    too_short: float

    def stack(self, place: int, ms: int, *, exact: bool = False) -> tuple[Values, Values]:
        """Return values and spreads, shape (n, 3), of what is known ``ms`` after the contact."""
        out = np.full((2, len(self.gaps), 3), np.nan)
        out[..., 0] = self.first[min(place, len(FIRST) - 1), :2]
        is_there = 1e3 * (self.gaps + SECOND) <= ms
        out[..., 1] = np.where(is_there, self.second, np.nan)
        if ms in SQUEEZES:
            out[..., 2] = (self.exact if exact else self.squeeze)[SQUEEZES.index(ms)]
        return out[0], out[1]


def measure(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    if subject.name not in CONDITIONS:
        return PartResult()
    first, *others = settings.rig_seeds
    seeds = [first, *(others or [first + 1])]  # intervals need two hands
    hands = range(LAW_SEED, LAW_SEED + (2 if settings.brief else LAW_HANDS))
    sizes = Sizes(blocks=6, objects=1, random=8) if settings.brief else Sizes()
    jobs = [*((seed, False) for seed in seeds), *((seed, True) for seed in hands)]
    estimates = runner.map(_estimates, jobs, subject.name, sizes, settings.seed)
    scored, known = estimates[: len(seeds)], estimates[len(seeds) :]
    law, exact = measure_law(known), measure_law(known, exact=True)
    rows = np.array([[_scores(each, law, exact) for each in scored]]).swapaxes(0, 1)
    (scores,) = rig_scores(rows, KEYS, settings.seed)
    results = WholeGrasp(
        seeds=seeds,
        pinches={use: sum(int((each.uses == use).sum()) for each in scored) for use in USES},
        too_short=float(np.mean([each.too_short for each in scored])),
        second_ms=1e3 * float(np.mean([each.gaps.mean() for each in scored]) + SECOND),
        law=law,
        methods={name: _without_gaps(method) for name, method in zip(METHODS, scores, strict=True)},
    )
    return PartResult([WHOLE_GRASP(results)], [time_figure(results)])


def _estimates(job: tuple[int, bool], condition: str, sizes: Sizes, seed: int) -> _Estimates:
    """Simulate a hand, calibrate it on its blocks, and return its estimates of other objects."""
    hand, is_random = job
    pinches = grasps(hand, condition, sizes, is_random=is_random)
    own = pinches.uses == OWN
    shore_a, sessions = pinches.shore_a[own], pinches.sessions[own]

    first, second = (
        adapt_combined(pretrained(), touches.take(own), shore_a, sessions, seed).model
        for touches in (pinches.first, pinches.second)
    )
    by_time = predictions_by_time(first, pinches.first.take(~own), FIRST)
    late = second.predict_touches(pinches.second.take(~own))

    def squeezed(features: Values) -> Values:
        out = np.full((len(SQUEEZES), 2, int((~own).sum())), np.nan)
        for row, each in enumerate(features):
            is_there = np.isfinite(each).all(axis=1)
            known, asked = own & is_there, is_there[~own]
            scale = SqueezeScale.fit(each[known], pinches.shore_a[known], pinches.sessions[known])
            out[row, 0, asked] = scale.predict(each[~own & is_there])
            out[row, 1, asked] = scale.error
        return out

    return _Estimates(
        np.array([[p.value, p.spread, p.low, p.high] for p in by_time.values()]),
        np.array([late.value, late.spread]),
        squeezed(pinches.squeezes),
        squeezed(pinches.exact),
        pinches.gaps[~own],
        pinches.shore_a[~own],
        pinches.uses[~own],
        pinches.too_short / (pinches.too_short + len(own)),
    )


def measure_law(known: Sequence[_Estimates], *, exact: bool = False) -> GraspLaw:
    """Measure on these hands how the estimates of fingers and squeeze are averaged."""
    stacks = [each.stack(len(TIMES), SETTLED, exact=exact) for each in known]
    values, spreads = (np.concatenate(arrays) for arrays in zip(*stacks, strict=True))
    gaps = np.concatenate([each.gaps for each in known])
    return GraspLaw.measure(values, spreads, gaps, np.concatenate([e.shore_a for e in known]))


def _scores(estimates: _Estimates, law: GraspLaw, exact: GraspLaw) -> list[list[float]]:
    """Return the scores of a hand, shape (methods, ``KEYS``): squared errors instead of RMSE."""
    out: dict[str, list[float]] = {name: [] for name in METHODS}
    by_time = [_predictions(estimates, place, ms, law, exact) for place, ms in enumerate(TIMES)]
    for use in USES:
        rows = estimates.uses == use
        truth = estimates.shore_a[rows]
        for at_time in by_time:
            for name in METHODS:
                value, low, high = (array[rows] for array in at_time[name])
                is_there = np.isfinite(value)
                if not is_there.any():
                    out[name] += [np.nan] * len(SCORES)
                    continue
                value, low, high, true = (a[is_there] for a in (value, low, high, truth))
                errors, inside = value - true, (low <= true) & (true <= high)
                means = (errors**2, errors, inside, high - low)
                out[name] += [float(np.mean(each)) for each in means]
    return list(out.values())


def _predictions(
    estimates: _Estimates, place: int, ms: int, law: GraspLaw, exact: GraspLaw
) -> Mapping[str, tuple[Values, Values, Values]]:
    """Return value, low and high of each method, ``ms`` after the first contact."""
    value, _, low, high = estimates.first[min(place, len(FIRST) - 1)]
    out = {"first": (value, low, high)}
    for name, rule, uses_squeeze in (
        ("fingers", law, False), ("sharpened", law, True), ("sharpened_exact", exact, True),
    ):  # fmt: skip
        values, spreads = estimates.stack(place, ms, exact=rule is exact)
        if not uses_squeeze:
            values[:, 2] = np.nan
        out[name] = rule.sharpen(values, spreads, estimates.gaps, out["first"])
    nothing = np.full(len(value), np.nan)
    for name, squeezes in (("squeeze", estimates.squeeze), ("exact", estimates.exact)):
        value, error = squeezes[SQUEEZES.index(ms)] if ms in SQUEEZES else (nothing, nothing)
        half = NORMAL * error
        out[name] = value, value - half, value + half
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
    """Return the figure of error against time after the first contact."""
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
        f"One estimate that sharpens, and the classical stiffness of the squeeze on the same "
        f"pinches. Simulated hands; bands are 95 % bootstrap intervals over {len(results.seeds)} "
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
        "hands; in brackets that of the difference from the first finger at the same time. Without "
        f"pinches in which the second finger touches within 2 ms ({100 * grasp.too_short:.0f} %)."
    )
    lines = []
    for name, times in _LINES:
        for ms in times:
            when = f"{grasp.second_ms:.0f} ms on average" if name == "fingers" else f"{ms} ms"
            scores = grasp.methods[name]
            cells = [scores.cell(f"{use} {ms} {key}", unit) for key, unit in _UNITS.items()]
            if any(cell.text != ABSENT for cell in cells):
                lines.append(Line([Cell(f"{METHODS[name]}, {when}"), *cells]))
    return Table(caption, ["", "RMSE", "Bias", "Coverage", "Width"], lines)


def _text(subjects: Subjects) -> str:
    text = (
        "The first finger's estimates are those of the shipped model, adapted to blocks. The "
        f"second finger's first {1e3 * SECOND:.0f} ms are predicted by the same network, adapted "
        "to second contacts on blocks. The classical method measures the stiffness of the squeeze "
        "from the force cells and the travel of the drives (200 positions a second with an error "
        "of 0.1 mm), calibrated on blocks, too; its interval comes from held-out blocks. “Exact "
        "sensors” have the true force and compression at the fingertips. All "
        "together averages these estimates by their errors."
    )
    for results in subjects.values():
        if (grasp := results[WHOLE_GRASP]) is not None:
            law = grasp.law
            return (
                f"{text} Their errors were measured on other hands, which are random, with other "
                "objects of the same random and everyday kinds: so the average knows these kinds. "
                f"The errors of both fingers correlate by {law.correlations[0]:.2f}; the "
                f"second finger reads {1e-3 * law.drift:.2f} Shore A harder with each ms between "
                f"the contacts; and the squeeze reads objects {-law.softer:.0f} Shore A softer "
                f"than blocks of the same rubber, with a scatter of {law.structure:.0f}, because "
                "their shape and structure yield, too."
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
