"""Errors with a measured closing speed, on rigs whose kinds no network was trained on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Record
from firstcontact.core.jobs import Runner
from firstcontact.models.combined import CombinedModel, adapt_combined
from firstcontact.models.model_file import pretrained
from firstcontact.twin import CONDITIONS
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.tables import Cell, Line, Table
from firstcontact_lab.study._random_rigs import (
    EVERYDAY,
    OWN,
    RANDOM,
    STRUCTURES,
    JudgedRig,
    RigScores,
    families_and_jobs,
    judged_rig,
    rig_scores,
)
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject
from firstcontact_lab.study.scores import predictions_by_time

Values = NDArray[np.float64]
#: Seed of the rigs, and rigs of each family. No choice was made on rigs of this seed.
SEED, RIGS = 9108, 2
#: Times after the contact at which errors are scored, ms, and time of the coverage, ms.
TIMES, MIDDLE = (2, 5, 15), 5
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
KEYS = tuple(
    f"{use} {score}"
    for use in (EVERYDAY, RANDOM)
    for score in (*(f"{ms} ms" for ms in TIMES), "coverage")
)


class ClosingSpeeds(Record, frozen=True, kw_only=True):
    seed: int
    rigs: int
    families: list[str]
    scores: dict[str, dict[str, dict[str, RigScores]]]


def measure(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    """Score both models with each measurement, on random rigs instead of the subject's data."""
    if subject.name != CONDITIONS["paper-rig"].name:
        return PartResult()
    names, rigs, jobs = families_and_jobs(settings.brief, RIGS)
    scores: dict[str, dict[str, dict[str, RigScores]]] = {}
    for kind in SPEEDS:
        rows = np.array(runner.map(_scores_of_rig, jobs, SEED, kind == "free"))
        scores[kind] = {
            model: dict(zip(MEASUREMENTS, of_model, strict=True))
            for model, of_model in zip(MODELS, rig_scores(rows, KEYS, settings.seed), strict=True)
        }
    results = ClosingSpeeds(seed=SEED, rigs=rigs, families=names, scores=scores)
    return PartResult([CLOSING_SPEEDS(results)])


def _scores_of_rig(job: tuple[str, int], seed: int, free: bool) -> list[list[list[float]]]:
    """Return the scores of one rig, shape (models, speed measurements, ``KEYS``)."""
    rig = judged_rig(*job, seed, free_speed=free)
    rng = np.random.default_rng([seed, job[1], list(STRUCTURES).index(job[0])])
    scores = [_scores(_measured(rig, measured, rng)) for measured in MEASUREMENTS.values()]
    return [list(of_model) for of_model in zip(*scores, strict=True)]


def _measured(
    rig: JudgedRig, measured: tuple[float, bool] | None, rng: np.random.Generator
) -> JudgedRig:
    """Return the rig with measured closing speeds, which have a random error."""
    if measured is None:
        return rig
    error, is_stated = measured
    speeds = rig.speeds * np.exp(error * rng.standard_normal(len(rig.speeds)))
    errors = np.full(len(speeds), error if is_stated else np.nan)
    return replace(rig, touches=replace(rig.touches, speeds=speeds, speed_errors=errors))


def _scores(rig: JudgedRig) -> list[list[float]]:
    """Return mean squared errors and coverage of each model, shape (models, keys)."""
    is_context, touches = rig.uses == OWN, rig.touches
    model = adapt_combined(
        pretrained(), touches.take(is_context), rig.shore_a[is_context], rig.sessions[is_context]
    ).model
    network = model.network_alone() if isinstance(model, CombinedModel) else model
    out = []
    for each in (network, model):
        answers = predictions_by_time(each, touches, TIMES)
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
#: Columns of the tables: title, key and unit.
_COLUMNS = [
    ("Everyday objects, 2 ms", f"{EVERYDAY} 2 ms", "shore"),
    ("5 ms", f"{EVERYDAY} 5 ms", "shore"),
    ("15 ms", f"{EVERYDAY} 15 ms", "shore"),
    ("Random objects, 2 ms", f"{RANDOM} 2 ms", "shore"),
    ("5 ms", f"{RANDOM} 5 ms", "shore"),
    ("15 ms", f"{RANDOM} 15 ms", "shore"),
    ("Coverage, everyday, 5 ms", f"{EVERYDAY} coverage", "share"),
]


def _table(results: SubjectResults, kind: str) -> Table | None:
    judged = results[CLOSING_SPEEDS]
    if judged is None:
        return None
    caption = (
        f"{SPEEDS[kind]}: RMSE of one pinch, {judged.rigs} rigs of each of "
        f"{len(judged.families)} families (seed {judged.seed}). After each value: its 95 % "
        "bootstrap interval over rigs; in brackets the interval of the difference from the same "
        "model without a measurement."
    )
    lines = [
        Line([Cell(f"{title}, {name}"), *(scores.cell(key, unit) for _, key, unit in _COLUMNS)])
        for model, title in MODELS.items()
        for name, scores in judged.scores[kind][model].items()
    ]
    return Table(caption, ["", *(title for title, _, _ in _COLUMNS)], lines)


PART = Part(
    "closing_speed",
    "Measured closing speed",
    [Step("measured closing speed", measure, late=True, cost=60)],
    lambda subjects: (
        "Random rigs of other structure, as in the section on these. Their hands measure the "
        "closing speed of each pinch, on the rig's own blocks and on the objects. The model takes "
        "a speed without a stated error as exact."
    ),
    [lambda results: _table(results, "usual"), lambda results: _table(results, "free")],
    needs=(),
    by_default=False,
)
