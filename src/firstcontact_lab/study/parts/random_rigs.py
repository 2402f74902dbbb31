"""Study part ``random_rigs``: scores on families of simulated rigs not used for training.

The methods are the network, a regression, averages of both, and models that use a measured closing
speed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Record
from firstcontact.jobs import Runner
from firstcontact.models import Touches
from firstcontact.models.model_file import pretrained
from firstcontact.models.predictions import combine
from firstcontact.models.rig.combined import adapt_combined
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.rig.rigs import Rig
from firstcontact.signal import samples_in
from firstcontact.twin import CONDITIONS
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.tables import ABSENT, Cell, Line, Table
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject
from firstcontact_lab.study.random_rigs import (
    ALIKE,
    BLOCK,
    EVERYDAY,
    OWN,
    RANDOM,
    STRIPS,
    STRUCTURES,
    LabelledRig,
    RigScores,
    plan_rig_jobs,
    rig_scores,
    simulate_labelled_rig,
)
from firstcontact_lab.study.scores import predictions_by_time
from firstcontact_lab.study.window_ladder import LadderModel, fit_window_ladder

Values = NDArray[np.float64]
#: Seed of the rigs, and rigs of each family. No choice was made on rigs of this seed.
SEED, RIGS = 9107, 3
TIMES = (2, 5, 15)
#: Time of the pooled pinches, of coverage and of width, ms.
MIDDLE = 5
_USES = (BLOCK, EVERYDAY, RANDOM)
#: Scores of a method, in this order: by use the RMSE at each time, the bias at ``MIDDLE``, the RMSE
#: of three pinches, then coverage and width of one pinch and of three. For each rig, mean squared
#: errors are kept instead of the RMSE.
KEYS = tuple(
    f"{use} {score}"
    for use in _USES
    for score in (
        *(f"{ms} ms" for ms in TIMES),
        "bias",
        "three",
        "coverage",
        "width",
        "three coverage",
        "three width",
    )
)
METHODS = {
    "network": "Network",
    "network_radius": "Network, radius known",
    "svm": "SVM of the rig",
    "log_spectrum": "Log spectrum of the rig",
    "regression": "Regression on the rig's features",
    "combined": "Average of both",
    "combined_radius": "Average, radius known",
    "combined_told": "Average, radius and speed (± 3 %) known",
    "combined_plain": "Average, without the rig's offset",
    "combined_exact": "Average, all contacts placed alike",
    "combined_strips": "Average, contacts of copper strips",
    "combined_quiet": "Average, a tenth of the rig's noise",
}


class RandomRigs(Record, frozen=True, kw_only=True):
    seed: int
    rigs: int
    families: list[str]
    methods: dict[str, RigScores]
    #: Share of the average's 90 % intervals at ``MIDDLE`` that hold the truth, by family, over
    #: everyday and random objects.
    held: dict[str, float]


def measure(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    if subject.name != CONDITIONS["paper-rig"].name:
        return PartResult()
    names, rigs, jobs = plan_rig_jobs(settings.brief, RIGS)
    rows = np.array(runner.map(_scores_of_rig, jobs, SEED))
    (scores,) = rig_scores(rows[:, None], KEYS, settings.seed)
    methods = dict(zip(METHODS, scores, strict=True))
    places = [KEYS.index(f"{use} coverage") for use in (EVERYDAY, RANDOM)]
    shares = rows[:, list(METHODS).index("combined"), places].mean(axis=1)
    of_family = np.array([name for name, _ in jobs])
    held = {name: round(float(shares[of_family == name].mean()), 3) for name in names}
    results = RandomRigs(seed=SEED, rigs=rigs, families=names, methods=methods, held=held)
    return PartResult([RANDOM_RIGS(results)])


def _scores_of_rig(job: tuple[str, int], seed: int) -> list[list[float]]:
    """Return scores of all methods on one rig, as a list of ``KEYS`` for each method.

    ``job`` is (family of the rig, number of the rig). The scores are squared errors, coverages and
    widths of intervals.
    """
    rig = simulate_labelled_rig(*job, seed)
    told = _with_measured_speeds(rig, MEASUREMENTS["± 3 %"], np.random.default_rng([seed, job[1]]))
    exact, strips = (simulate_labelled_rig(*job, seed, delay=delay) for delay in (ALIKE, STRIPS))
    quiet = simulate_labelled_rig(*job, seed, is_quiet=True)
    predictions = {name: (rig, predict) for name, predict in _predictions(rig).items()} | {
        "combined_told": (told, _timed(_adapt_to_rig(told), told.radii)),
        "combined_exact": (exact, _timed(_adapt_to_rig(exact))),
        "combined_strips": (strips, _timed(_adapt_to_rig(strips))),
        "combined_quiet": (quiet, _timed(_adapt_to_rig(quiet))),
    }
    return [_scores(*predictions[name]) for name in METHODS]


#: Values, ends and half widths for contacts cut at a time, ms.
Predicted = tuple[Values, Values, Values, Values]
Predict = Callable[[Touches, int], Predicted]


def _block_pinches(rig: LabelledRig) -> tuple[Touches, Values, NDArray[np.str_]]:
    """Return (contacts with blocks to adapt to, Shore A, sessions) of the rig."""
    is_own = rig.uses == OWN
    return rig.touches.take(is_own), rig.shore_a[is_own], rig.sessions[is_own]


def _adapt_to_rig(rig: LabelledRig) -> RigModel:
    model = adapt_combined(pretrained(), *_block_pinches(rig)).model
    assert model.regressions
    return model


def _timed(model: RigModel, radii: Values | None = None) -> Predict:
    def predict(touches: Touches, ms: int) -> Predicted:
        early = touches.until(samples_in(1e-3 * ms, touches.rate))
        out = model.predict_touches(early if radii is None else replace(early, radii=radii))
        half = model.half_widths(out.spread, early.valid)
        return out.value, out.low, out.high, half

    return predict


def _windows(ladder: LadderModel) -> Predict:
    def predict(touches: Touches, ms: int) -> Predicted:
        out = ladder.predict_touches(touches.until(samples_in(1e-3 * ms, touches.rate)))
        return out.value, out.low, out.high, np.maximum(out.high - out.low, 1e-6) / 2

    return predict


def _predictions(rig: LabelledRig) -> dict[str, Predict]:
    pinches, combined = _block_pinches(rig), _adapt_to_rig(rig)
    network = combined.network_alone()
    none = np.zeros(len(Rig.STAGES))
    unshifted = {finger: r.shifted(none) for finger, r in combined.regressions.items()}

    def regression(touches: Touches, ms: int) -> Predicted:
        value, _ = combined.regress(touches.until(samples_in(1e-3 * ms, touches.rate)))
        return value, value, value, np.ones(len(value))

    return {
        "network": _timed(network),
        "network_radius": _timed(network, rig.radii),
        **{name: _windows(fit_window_ladder(name, *pinches)) for name in ("svm", "log_spectrum")},
        "regression": regression,
        "combined": _timed(combined),
        "combined_radius": _timed(combined, rig.radii),
        "combined_plain": _timed(combined.with_regressions(unshifted, combined.factors)),
    }


def _scores(rig: LabelledRig, predict: Predict) -> list[float]:
    answers = [predict(rig.touches, ms) for ms in TIMES]
    out = []
    middle = TIMES.index(MIDDLE)
    for use in _USES:
        rows = rig.uses == use
        truth = rig.shore_a[rows]
        errors = [answer[0][rows] - truth for answer in answers]
        out += [float(np.mean(error**2)) for error in errors]
        out.append(float(np.mean(errors[middle])))
        objects = rig.objects[rows]
        pooled = [errors[middle][objects == name].mean() for name in np.unique(objects)]
        value, low, high, half = (of_all[rows] for of_all in answers[middle])
        three = [
            (combine(value[same], half[same]), truth[same][0])
            for same in (objects == name for name in np.unique(objects))
        ]
        out += [
            float(np.mean(np.square(pooled))),
            float(((low <= truth) & (truth <= high)).mean()),
            float((high - low).mean()),
            float(np.mean([c.low <= shore_a <= c.high for c, shore_a in three])),
            float(np.mean([c.high - c.low for c, _ in three])),
        ]
    return out


RANDOM_RIGS = Field.optional("random_rigs", RandomRigs)
_COLUMNS = [
    ("Everyday objects, 2 ms", f"{EVERYDAY} 2 ms", "shore"),
    ("5 ms", f"{EVERYDAY} 5 ms", "shore"),
    ("15 ms", f"{EVERYDAY} 15 ms", "shore"),
    ("Bias, 5 ms", f"{EVERYDAY} bias", "bias"),
    ("Random objects, 5 ms", f"{RANDOM} 5 ms", "shore"),
    ("Bias, 5 ms", f"{RANDOM} bias", "bias"),
    ("Blocks of other sessions, 5 ms", f"{BLOCK} 5 ms", "shore"),
]
_MORE = [
    ("Three pinches, everyday", f"{EVERYDAY} three", "shore"),
    ("Three pinches, random", f"{RANDOM} three", "shore"),
    ("Coverage, everyday", f"{EVERYDAY} coverage", "share"),
    ("Coverage, random", f"{RANDOM} coverage", "share"),
    ("Width, everyday", f"{EVERYDAY} width", "shore"),
    ("Coverage of three, everyday", f"{EVERYDAY} three coverage", "share"),
    ("Coverage of three, random", f"{RANDOM} three coverage", "share"),
    ("Width of three, everyday", f"{EVERYDAY} three width", "shore"),
]
Columns = Sequence[tuple[str, str, str]]


def score_table(
    judged: RandomRigs | ClosingSpeeds, title: str, other: str, columns: Columns, lines: list[Line]
) -> Table:
    """Return a table of scores on random rigs, and of differences from the method ``other``."""
    caption = (
        f"{title}, {judged.rigs} rigs of each of {len(judged.families)} families "
        f"(seed {judged.seed}). After each value: its 95 % bootstrap interval over rigs; in "
        f"brackets the interval of the difference from {other}."
    )
    return Table(caption, ["", *(head for head, _, _ in columns)], lines)


def _table(results: SubjectResults, columns: Columns, title: str) -> Table | None:
    judged = results[RANDOM_RIGS]
    if judged is None:
        return None
    lines = []
    for name, scores in judged.methods.items():
        cells = [
            scores.cell(key, unit)
            if (unit != "share" and not key.endswith("width")) or name != "regression"
            else Cell(ABSENT)
            for _, key, unit in columns
        ]
        lines.append(Line([Cell(METHODS[name]), *cells]))
    return score_table(judged, title, "the network", columns, lines)


PART = Part(
    "random_rigs",
    "Random rigs of other structure",
    [Step("random rigs", measure, late=True, cost=60)],
    lambda subjects: (
        "Random rigs, objects and signals that differ from the training of the network in "
        "structure. Each method learns from the same 30, 60 or 100 block pinches of a rig. "
        "Contacts are placed 3 samples late (SD 2.5), and labels have an SD of 2 Shore A."
    ),
    [
        lambda results: _table(results, _COLUMNS, "RMSE of one pinch"),
        lambda results: _table(results, _MORE, "Three pinches pooled and 90 % intervals, 5 ms"),
    ],
    needs=(),
    by_default=False,
)


#: Seed of the rigs, and rigs of each family. No choice was made on rigs of this seed.
SPEED_SEED, SPEED_RIGS = 9108, 2
#: Relative standard error of the measured speeds, and True if the model gets this error; None
#: without a measurement.
MEASUREMENTS: dict[str, tuple[float, bool] | None] = {
    "not measured": None,
    "exact": (0.0, True),
    "± 3 %": (0.03, True),
    "± 6 %": (0.06, True),
    "± 12 %": (0.12, True),
    "± 20 %": (0.20, True),
    "± 12 %, error not stated": (0.12, False),
    "± 20 %, error not stated": (0.20, False),
}
MODELS = {"network": "Network", "combined": "Combined"}
#: Kinds of rigs: closing speeds as in the training of the network, or drawn for each pinch.
SPEEDS = {
    "usual": "Closing speed that varies only as much as when one hand repeats a closing",
    "free": "Closing speed of each pinch from 0.5 to 2 times the usual one",
}
#: Scores of a model with a measurement: RMSE by use and time, and coverage at ``MIDDLE``. For each
#: rig, mean squared errors are kept instead of the RMSE.
SPEED_KEYS = tuple(
    f"{use} {score}"
    for use in (EVERYDAY, RANDOM)
    for score in (*(f"{ms} ms" for ms in TIMES), "coverage")
)


class ClosingSpeeds(Record, frozen=True, kw_only=True):
    seed: int
    rigs: int
    families: list[str]
    scores: dict[str, dict[str, dict[str, RigScores]]]


def measure_speed(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    if subject.name != CONDITIONS["paper-rig"].name:
        return PartResult()
    names, rigs, jobs = plan_rig_jobs(settings.brief, SPEED_RIGS)
    scores: dict[str, dict[str, dict[str, RigScores]]] = {}
    for kind in SPEEDS:
        rows = np.array(runner.map(_speed_scores_of_rig, jobs, SPEED_SEED, kind == "free"))
        scores[kind] = {
            model: dict(zip(MEASUREMENTS, of_model, strict=True))
            for model, of_model in zip(
                MODELS, rig_scores(rows, SPEED_KEYS, settings.seed), strict=True
            )
        }
    results = ClosingSpeeds(seed=SPEED_SEED, rigs=rigs, families=names, scores=scores)
    return PartResult([CLOSING_SPEEDS(results)])


def _speed_scores_of_rig(job: tuple[str, int], seed: int, free: bool) -> list[list[list[float]]]:
    """Return scores on one rig, shape (models, errors of the measured speed, keys).

    ``job`` is (family of the rig, number of the rig). With ``free``, the closing speed is random.
    """
    rig = simulate_labelled_rig(*job, seed, free_speed=free)
    rng = np.random.default_rng([seed, job[1], list(STRUCTURES).index(job[0])])
    scores = [
        _speed_scores(_with_measured_speeds(rig, measured, rng))
        for measured in MEASUREMENTS.values()
    ]
    return [list(of_model) for of_model in zip(*scores, strict=True)]


def _with_measured_speeds(
    rig: LabelledRig, measured: tuple[float, bool] | None, rng: np.random.Generator
) -> LabelledRig:
    """Return the rig with measured closing speeds, or unchanged if ``measured`` is None.

    ``measured`` is (relative error of the speeds, True if the model is given this error).
    """
    if measured is None:
        return rig
    error, is_stated = measured
    speeds = rig.speeds * np.exp(error * rng.standard_normal(len(rig.speeds)))
    errors = np.full(len(speeds), error if is_stated else np.nan)
    return replace(rig, touches=replace(rig.touches, speeds=speeds, speed_errors=errors))


def _speed_scores(rig: LabelledRig) -> list[list[float]]:
    """Return mean squared error and coverage of each model on one rig, (models, ``SPEED_KEYS``)."""
    model = _adapt_to_rig(rig)
    out = []
    for each in (model.network_alone(), model):
        answers = predictions_by_time(each, rig.touches, TIMES)
        scores = []
        for use in (EVERYDAY, RANDOM):
            rows = rig.uses == use
            truth = rig.shore_a[rows]
            scores += [float(np.mean((answers[ms].value[rows] - truth) ** 2)) for ms in TIMES]
            low, high = answers[MIDDLE].low[rows], answers[MIDDLE].high[rows]
            scores.append(float(((low <= truth) & (truth <= high)).mean()))
        out.append(scores)
    return out


CLOSING_SPEEDS = Field.optional("closing_speed", ClosingSpeeds)
_SPEED_COLUMNS = [
    ("Everyday objects, 2 ms", f"{EVERYDAY} 2 ms", "shore"),
    ("5 ms", f"{EVERYDAY} 5 ms", "shore"),
    ("15 ms", f"{EVERYDAY} 15 ms", "shore"),
    ("Random objects, 2 ms", f"{RANDOM} 2 ms", "shore"),
    ("5 ms", f"{RANDOM} 5 ms", "shore"),
    ("15 ms", f"{RANDOM} 15 ms", "shore"),
    ("Coverage, everyday, 5 ms", f"{EVERYDAY} coverage", "share"),
]


def _speed_table(results: SubjectResults, kind: str) -> Table | None:
    judged = results[CLOSING_SPEEDS]
    if judged is None:
        return None
    lines = [
        Line([Cell(f"{title}, {name}"), *(s.cell(key, unit) for _, key, unit in _SPEED_COLUMNS)])
        for model, title in MODELS.items()
        for name, s in judged.scores[kind][model].items()
    ]
    other = "the same model without a measurement"
    return score_table(judged, f"{SPEEDS[kind]}: RMSE of one pinch", other, _SPEED_COLUMNS, lines)


SPEED_PART = Part(
    "closing_speed",
    "Measured closing speed",
    [Step("measured closing speed", measure_speed, late=True, cost=60)],
    lambda subjects: (
        "Random rigs of other structure, as in the section on these. Their hands measure the "
        "closing speed of each pinch, on the rig's own blocks and on the objects. The model takes "
        "a speed without a stated error as exact."
    ),
    [lambda results: _speed_table(results, "usual"), lambda results: _speed_table(results, "free")],
    needs=(),
    by_default=False,
)
