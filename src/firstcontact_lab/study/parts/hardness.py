"""Order of hardness where no Shore A is known: ranks and materials only."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from msgspec.structs import asdict

from firstcontact.core import Runner
from firstcontact.models import (
    DURATION,
    ESTIMATORS,
    ClassificationScores,
    LabelledWindows,
    Question,
    RankCorrelation,
    Task,
    Values,
    classification_scores,
    held_out,
    learns_one_value,
    leave_one_out,
    never_learned,
    random_folds,
    rank_correlation,
    regression_scores,
    window_estimators,
)
from firstcontact_lab.report import names
from firstcontact_lab.report.figures.hardness import hardness_figure, materials_figure
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.results.hardness import (
    HardnessOrder,
    Material,
    MaterialLeftOut,
    RankRegression,
)
from firstcontact_lab.report.results.study import SubjectResults
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.settings import StudySettings

#: The score that orders materials without any training. Declared before any
#: result was seen: a harder surface gives a shorter contact (Hertz), so more
#: of the energy of the first 15 ms lies at high frequencies.
SCORE = "spectral centroid of the first 15 ms after contact, Hz"
#: A whole material left out, and random folds with every material on both sides.
HELD, MIXED = "leave_one_material_out", "random_folds"


def spectral_centroid(X: np.ndarray[Any, np.dtype[np.float32]], rate: float) -> Values:
    """Centre of gravity of the power spectrum of Hann-weighted windows.

    Parameters
    ----------
    X
        Windows, shape (n, samples, 1), V.
    rate
        Hz.

    Returns
    -------
    ndarray
        Hz, shape (n,).
    """
    waves = X[:, :, 0].astype(np.float64)
    # The contact is at the window's start: only its end is weighed down.
    fade = np.hanning(2 * waves.shape[1])[waves.shape[1] :]
    power = np.abs(np.fft.rfft(waves * fade, axis=1)) ** 2
    frequencies = np.fft.rfftfreq(waves.shape[1], 1.0 / rate)
    centroid: Values = (power * frequencies).sum(axis=1) / power.sum(axis=1)
    return centroid


def hardness(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    """Spearman over materials, and models with a whole material left out."""
    if not subject.has_known_contacts:
        return PartResult(left_out=["Hardness order: no pinch has a known first contact."])
    dataset = subject.dataset
    rank = dataset.hardness_rank
    known = np.isfinite(rank) & (dataset.objects != "")
    data = subject.labelled_windows(DURATION, np.where(known, rank, np.nan))
    if len(np.unique(data.y)) < 2 or len(np.unique(data.objects)) < 3:
        return PartResult(
            left_out=[
                "Hardness order: fewer than three materials or two hardness ranks, counting those "
                "of which a window was found."
            ]
        )
    centroid = spectral_centroid(data.X, data.rate)
    seed = settings.seed
    questions, left_out = _questions(data, settings)
    predicted = dict(
        zip(
            questions,
            held_out(runner, list(questions.values()), seed),
            strict=True,
        )
    )
    ranked = predicted.get((HELD, "rank"))
    by_material = _by_material(data, centroid, ranked)
    order = np.array([its.rank for its in by_material.values()])

    def correlation(of: Callable[[Material], float | None]) -> RankCorrelation:
        values = np.array(list(map(of, by_material.values())), dtype=np.float64)
        return rank_correlation(order, values, seed)

    def classes(place: str) -> dict[str, ClassificationScores]:
        return {
            model: classification_scores(data.y, predicted[place, model], data.objects, seed)
            for model in _classifiers()
            if (place, model) in predicted
        }

    regression = None
    if ranked is not None:
        errors = regression_scores(data.y, ranked, data.objects, seed)
        rho = correlation(lambda its: its.predicted)
        regression = RankRegression(**asdict(rho), errors=errors)
    found, mixed = classes(HELD), classes(MIXED)
    held = MaterialLeftOut(rank_regression=regression, classification=found or None)
    order_found = HardnessOrder(
        n_pinches=len(data),
        pinches=int(known.sum()),
        score=SCORE,
        spectral_centroid=correlation(lambda its: its.centroid_hz),
        by_material=by_material,
        leave_one_material_out=held if regression or found else None,
        random_folds=mixed or None,
    )
    figures = [hardness_figure(data, centroid)]
    for model in names.estimators(mixed):
        if model in found:
            figures.append(materials_figure(found[model], mixed[model]))
    return PartResult(SubjectResults(hardness_order=order_found), figures, left_out)


def _questions(
    data: LabelledWindows, settings: StudySettings
) -> tuple[dict[tuple[str, str], Question], list[str]]:
    """What these windows permit, and why not the rest."""
    out: dict[tuple[str, str], Question] = {}
    left_out = []
    reference = ESTIMATORS.default
    held = leave_one_out(data.objects)
    if learns_one_value(held, data.y):
        left_out.append(
            "Order of hardness by regression: without one of the materials, a single hardness rank "
            "is left to learn from."
        )
    else:
        out[HELD, "rank"] = Question(
            reference, Task.REGRESSION, data, held, settings.options(reference)
        )
    unknown = never_learned(held, data.y)
    if len(unknown):
        left_out.append(
            "Hardness class with a material left out: the ranks "
            f"{', '.join(f'{r:g}' for r in unknown)} have one material each, so no model could "
            "have learned them without it."
        )
    elif not learns_one_value(held, data.y):
        for model in _classifiers():
            out[HELD, model] = Question(
                model, Task.CLASSIFICATION, data, held, settings.options(model)
            )
    if np.unique(data.y, return_counts=True)[1].min() < 2:
        left_out.append("Hardness class in random folds: a rank has a single pinch.")
    else:
        folds = random_folds(data.y, settings.seed)
        options = settings.options(reference)
        out[MIXED, reference] = Question(reference, Task.CLASSIFICATION, data, folds, options)
    return out, left_out


def _classifiers() -> list[str]:
    """What is asked for the class, floors last: all that learns it quickly."""
    able = [
        n for n, e in window_estimators().items() if Task.CLASSIFICATION in e.tasks and not e.slow
    ]
    return sorted(able, key=names.is_floor)


def _by_material(
    data: LabelledWindows, centroid: Values, predicted: Values | None
) -> dict[str, Material]:
    out = {}
    for material in np.unique(data.objects):
        its = data.objects == material
        out[str(material)] = Material(
            rank=float(data.y[its].mean()),
            n=int(its.sum()),
            centroid_hz=float(centroid[its].mean()),
            predicted=None if predicted is None else float(predicted[its].mean()),
        )
    return out
