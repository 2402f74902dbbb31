"""Hardness from the first milliseconds of materials left out, where no Shore A is known.

Which signal, which contacts and which estimator is asked is told beside one another: the
signal as the device sent it and behind the published conditioning, contacts as found and as
labelled, what is made to move between sensors and what is used by default.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from firstcontact.core import Runner
from firstcontact.models import (
    DURATION,
    ESTIMATORS,
    TIMES,
    LabelledWindows,
    Question,
    RankCorrelation,
    Task,
    Values,
    held_out,
    leave_one_out,
    never_learned,
    rank_correlation,
    window_estimators,
)
from firstcontact_lab.report.figures.short_windows import (
    accuracy_figure,
    by_material_figure,
    order_figure,
)
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.results.real import Reading, RealMaterial, RealSet
from firstcontact_lab.report.results.study import SubjectResults
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.parts.hardness import SCORE, spectral_centroid
from firstcontact_lab.study.settings import StudySettings

#: Lengths of windows of a brief study, ms.
BRIEF = (3, 15)


@dataclass(frozen=True, slots=True)
class _Way:
    estimator: str
    conditioned: bool
    known: bool


def short_windows(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    """Classes of materials left out from short windows, and their order by a fixed score."""
    if not subject.has_known_contacts:
        return PartResult(
            left_out=["Short windows of materials left out: no pinch has a known first contact."]
        )
    ways = _ways(subject)
    full = {way: _windows(subject, way, DURATION) for way in ways}
    data = full[ways[0]]
    if lacking := _lacking(data):
        return PartResult(left_out=[f"Short windows of materials left out: {lacking}."])
    lengths = BRIEF if settings.brief else TIMES
    asked = {
        (way, ms): Question(
            way.estimator,
            Task.CLASSIFICATION,
            windows := _windows(subject, way, 1e-3 * ms),
            leave_one_out(windows.objects),
            settings.options(way.estimator),
        )
        for way in ways
        for ms in lengths
    }
    answers = held_out(runner, list(asked.values()), settings.seed)
    right = {
        key: _by_material(question.data, predicted)
        for (key, question), predicted in zip(asked.items(), answers, strict=True)
    }
    ranks = {str(m): float(data.y[data.objects == m][0]) for m in np.unique(data.objects)}
    readings = [
        Reading(
            estimator=way.estimator,
            conditioned=way.conditioned,
            known_contacts=way.known,
            n=len(full[way]),
            material_held_out={str(ms): _balanced(right[way, ms], ranks) for ms in lengths},
        )
        for way in ways
    ]
    own = {str(ms): right[ways[0], ms] for ms in lengths}
    found = _set(subject, data, readings, own, ranks, settings.seed)
    figures = [accuracy_figure(found), by_material_figure(found), order_figure(found)]
    return PartResult(SubjectResults(real={subject.set_name: found}), figures)


def _ways(subject: Subject) -> list[_Way]:
    """The one that the numbers are of first; then what differs from it."""
    moves = [
        n for n, e in window_estimators().items() if e.moves and Task.CLASSIFICATION in e.tasks
    ]
    first, *others = moves or [ESTIMATORS.default]
    known = not subject.found
    ways = [_Way(first, False, known)]
    if subject.found:
        ways.append(_Way(first, False, True))
    ways += [_Way(other, False, known) for other in others]
    return [*ways, _Way(first, True, known), _Way(ESTIMATORS.default, True, known)]


def _windows(subject: Subject, way: _Way, duration: float) -> LabelledWindows:
    """Windows of known materials; a material is one session, so that choices leave out whole."""
    dataset = subject.dataset
    rank = np.where(dataset.objects != "", dataset.hardness_rank, np.nan)
    contacts = subject.truth if way.known else subject.starts
    found = subject.labelled_windows(duration, rank, contacts, conditioned=way.conditioned)
    return replace(found, sessions=found.objects, specimens=found.objects)


def _lacking(data: LabelledWindows) -> str:
    """Why these windows do not permit it, if they do not."""
    materials, ranks = np.unique(data.objects), np.unique(data.y)
    if len(ranks) < 2 or len(materials) < 4:
        return "fewer than two hardness ranks or four materials have a window"
    if any(len(np.unique(data.y[data.objects == m])) > 1 for m in materials):
        return "a material has two hardness ranks"
    unknown = never_learned(leave_one_out(data.objects), data.y)
    if len(unknown):
        return f"the ranks {', '.join(f'{r:g}' for r in unknown)} have one material each"
    return ""


def _by_material(data: LabelledWindows, predicted: Values) -> dict[str, float]:
    """Share of each material's windows that are classed right."""
    right = predicted == data.y
    return {str(m): float(right[data.objects == m].mean()) for m in np.unique(data.objects)}


def _balanced(right: dict[str, float], ranks: dict[str, float]) -> float:
    of_ranks: dict[float, list[float]] = {}
    for material, share in right.items():
        of_ranks.setdefault(ranks[material], []).append(share)
    return float(np.mean([np.mean(shares) for shares in of_ranks.values()]))


def _set(
    subject: Subject,
    data: LabelledWindows,
    readings: list[Reading],
    right: dict[str, dict[str, float]],
    ranks: dict[str, float],
    seed: int,
) -> RealSet:
    conditioned = _windows(subject, _Way("", True, readings[0].known_contacts), DURATION)
    raw_hz, smooth_hz = _centroids(data), _centroids(conditioned)
    materials = [m for m in ranks if m in smooth_hz]
    order = np.array([ranks[m] for m in materials])

    def correlation(hertz: dict[str, float]) -> RankCorrelation:
        return rank_correlation(order, np.array([hertz[m] for m in materials]), seed)

    raw = correlation(raw_hz)
    return RealSet(
        n=len(data),
        materials=len(ranks),
        material_held_out=readings[0].material_held_out,
        chance=1.0 / len(set(ranks.values())),
        score=SCORE,
        rho=raw.rho,
        p=raw.p,
        most_rho=_most(order),
        conditioned_order=correlation(smooth_hz),
        readings=readings,
        by_material={
            m: RealMaterial(
                rank=ranks[m],
                n=int((data.objects == m).sum()),
                accuracy={ms: its[m] for ms, its in right.items() if m in its},
                centroid_hz=raw_hz[m],
                conditioned_centroid_hz=smooth_hz[m],
            )
            for m in materials
        },
    )


def _centroids(data: LabelledWindows) -> dict[str, float]:
    hertz = spectral_centroid(data.X, data.rate)
    return {str(m): float(hertz[data.objects == m].mean()) for m in np.unique(data.objects)}


def _most(order: Values) -> float:
    """Spearman of a score without ties that keeps the order."""
    from scipy.stats import spearmanr

    return float(spearmanr(np.sort(order), np.arange(len(order))).statistic)
