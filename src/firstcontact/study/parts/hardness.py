"""Order of hardness where no Shore A is known: ranks and materials only."""

from __future__ import annotations

from typing import Any

import numpy as np

from firstcontact.stiffness.estimator import Task
from firstcontact.study.figures.hardness import hardness_figure, materials_figure
from firstcontact.study.jobs import Runner
from firstcontact.study.metrics import (
    Values,
    classification_scores,
    rank_correlation,
    regression_scores,
)
from firstcontact.study.settings import DURATION, Settings
from firstcontact.study.splits import leave_one_out, random_folds
from firstcontact.study.subject import Outcome, Subject
from firstcontact.study.training import Examples, Question, examples, held_out

#: The score that orders materials without any training. Declared before any
#: result was seen: a harder surface gives a shorter contact (Hertz), so more
#: of the energy of the first 15 ms lies at high frequencies.
SCORE = "spectral centroid of the first 15 ms after contact, Hz"


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


def hardness(subject: Subject, settings: Settings, runner: Runner) -> Outcome:
    """Spearman over materials, and models with a whole material left out."""
    dataset = subject.dataset
    rank = dataset.hardness_rank
    known = np.isfinite(rank) & (dataset.objects != "")
    if len(np.unique(rank[known])) < 2 or len(np.unique(dataset.objects[known])) < 3:
        return Outcome(
            left_out=["Hardness order: fewer than three materials or two hardness ranks."]
        )
    target = np.where(known, rank, np.nan)
    data = examples(dataset, subject.starts, DURATION, target)
    centroid = spectral_centroid(data.X, data.rate)
    held = leave_one_out(data.objects)
    mixed = random_folds(data.y, settings.seed)
    questions = [
        Question("svm", Task.REGRESSION, data, held),
        Question("svm", Task.CLASSIFICATION, data, held),
        Question("svm", Task.CLASSIFICATION, data, mixed),
        Question("train_mean", Task.CLASSIFICATION, data, held),
        Question("peak", Task.CLASSIFICATION, data, held),
    ]
    ranked, classes, random, floor, peak = held_out(
        runner, questions, settings.seed, settings.epochs
    )
    by_material = _by_material(data, centroid, ranked)
    materials = list(by_material)
    order = np.array([by_material[m]["rank"] for m in materials])
    seed = settings.seed
    chance = _chance(data)
    mixed_scores = classification_scores(data.y, random, data.objects, seed)
    left_out_scores = {
        "svm": classification_scores(data.y, classes, data.objects, seed),
        "peak": classification_scores(data.y, peak, data.objects, seed),
        "train_mean": classification_scores(data.y, floor, data.objects, seed),
    }
    tree = {
        "n_pinches": len(data),
        "pinches": int(known.sum()),
        "score": SCORE,
        "spectral_centroid": rank_correlation(
            order, np.array([by_material[m]["centroid_hz"] for m in materials]), seed
        ),
        "leave_one_material_out": {
            "rank_regression": {
                **rank_correlation(
                    order, np.array([by_material[m]["predicted"] for m in materials]), seed
                ),
                "errors": regression_scores(data.y, ranked, data.objects, seed),
            },
            "classification": left_out_scores,
        },
        "random_folds": {"svm": mixed_scores},
        "chance": chance,
        "by_material": by_material,
    }
    figures = [
        hardness_figure(data, centroid),
        materials_figure(left_out_scores["svm"], mixed_scores, chance),
    ]
    return Outcome({"hardness_order": tree}, figures)


def _chance(data: Examples) -> float:
    """Accuracy of guessing each class as often as it comes."""
    share = np.unique(data.y, return_counts=True)[1] / len(data)
    return float((share**2).sum())


def _by_material(data: Examples, centroid: Values, predicted: Values) -> dict[str, dict[str, Any]]:
    out = {}
    for material in np.unique(data.objects):
        its = data.objects == material
        out[str(material)] = {
            "rank": float(data.y[its].mean()),
            "n": int(its.sum()),
            "centroid_hz": float(centroid[its].mean()),
            "predicted": float(predicted[its].mean()),
        }
    return out
