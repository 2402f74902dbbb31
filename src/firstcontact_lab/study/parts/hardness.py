"""Study part ``hardness``: predicted order of materials whose Shore A is unknown."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from msgspec.structs import asdict

from firstcontact.core import Record
from firstcontact.core.display import INK
from firstcontact.jobs import Runner
from firstcontact.models import ESTIMATORS, Task
from firstcontact.models.labelled_data import DURATION, LabelledWindows
from firstcontact.models.registry import window_estimators
from firstcontact.models.scores import (
    ClassificationScores,
    RegressionScores,
    classification_scores,
    regression_scores,
)
from firstcontact.models.splits import by_session, leave_one_out
from firstcontact.models.training import Question, held_out
from firstcontact.models.values import Values
from firstcontact.plots.style import figure_label
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import Figure, PartResult, missing
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.style import canvas, shades, uri
from firstcontact_lab.report.tables import Cell, Row, Table, Value, bounded, matrix, optional
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject, Subjects, with_ranks
from firstcontact_lab.study.parts.blocks import BLOCKS
from firstcontact_lab.study.parts.contacts import is_learned
from firstcontact_lab.study.parts.objects import OBJECTS
from firstcontact_lab.study.scores import (
    RankCorrelation,
    learns_one_value,
    never_learned,
    random_folds,
    rank_correlation,
)


class Material(Record, frozen=True, kw_only=True):
    rank: float
    n: int
    centroid_hz: float
    predicted: float | None = None


class RankRegression(RankCorrelation, frozen=True, kw_only=True):
    errors: RegressionScores


class MaterialLeftOut(Record, frozen=True, kw_only=True):
    rank_regression: RankRegression | None = None
    classification: dict[str, ClassificationScores] | None = None


class HardnessOrder(Record, frozen=True, kw_only=True):
    n_pinches: int
    pinches: int
    score: str
    spectral_centroid: RankCorrelation
    by_material: dict[str, Material]
    leave_one_material_out: MaterialLeftOut | None = None
    by_session: dict[str, ClassificationScores] | None = None
    random_folds: dict[str, ClassificationScores] | None = None

    @property
    def rho_left_out(self) -> float | None:
        """Spearman's rho of true and predicted ranks of left-out materials; None if unmeasured."""
        left_out = self.leave_one_material_out
        regression = left_out.rank_regression if left_out else None
        return regression.rho if regression else None

    def classes_left_out(self) -> dict[str, ClassificationScores]:
        """Return scores of hardness classes predicted for left-out materials, by estimator."""
        left_out = self.leave_one_material_out
        return (left_out.classification if left_out else None) or {}


#: Score that orders materials without any training. It was chosen before any result was seen: a
#: harder surface gives a shorter contact (Hertz), so more of the energy of the first 15 ms lies at
#: high frequencies.
SCORE = "spectral centroid of the first 15 ms after contact, Hz"


#: A whole material left out, whole sessions, and random folds with every material on both sides.
HELD, SESSION, MIXED = "leave_one_material_out", "by_session", "random_folds"


def spectral_centroid(X: np.ndarray[Any, np.dtype[np.float32]], rate: float) -> Values:
    """Return the centroid frequency of the power spectrum of each window, Hz.

    The window function is that of Hann. ``rate`` is the sample rate, Hz.
    """
    waves = X[:, :, 0].astype(np.float64)
    # The contact is at the start of the window, so only the end of the window is tapered.
    fade = np.hanning(2 * waves.shape[1])[waves.shape[1] :]
    power = np.abs(np.fft.rfft(waves * fade, axis=1)) ** 2
    frequencies = np.fft.rfftfreq(waves.shape[1], 1.0 / rate)
    centroid: Values = (power * frequencies).sum(axis=1) / power.sum(axis=1)
    return centroid


def hardness(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    if not subject.has_known_contacts:
        return missing("Hardness order: no pinch has a known first contact.")
    dataset = subject.dataset
    rank = dataset.hardness_rank
    is_known = np.isfinite(rank) & (dataset.objects != "")
    data = subject.labelled_windows(DURATION, np.where(is_known, rank, np.nan))
    if len(np.unique(data.y)) < 2 or len(np.unique(data.objects)) < 3:
        return missing(
            "Hardness order: the pinches with a window have fewer than three materials, or "
            "fewer than two hardness ranks."
        )
    centroid = spectral_centroid(data.X, data.rate)
    seed = settings.seed
    questions, left_out = _questions(data, settings)
    predicted = dict(zip(questions, held_out(runner, list(questions.values()), seed), strict=True))
    ranked = predicted.get((HELD, "rank"))
    by_material = _by_material(data, centroid, ranked)
    order = np.array([material.rank for material in by_material.values()])

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
        rho = correlation(lambda material: material.predicted)
        regression = RankRegression(**asdict(rho), errors=errors)
    left_out_classes, mixed = classes(HELD), classes(MIXED)
    left_out_material = MaterialLeftOut(
        rank_regression=regression, classification=left_out_classes or None
    )
    order_found = HardnessOrder(
        n_pinches=len(data),
        pinches=int(is_known.sum()),
        score=SCORE,
        spectral_centroid=correlation(lambda material: material.centroid_hz),
        by_material=by_material,
        leave_one_material_out=left_out_material if regression or left_out_classes else None,
        by_session=classes(SESSION) or None,
        random_folds=mixed or None,
    )
    return PartResult([HARDNESS(order_found)], [hardness_figure(data, centroid)], left_out)


def _questions(
    data: LabelledWindows, settings: StudySettings
) -> tuple[dict[tuple[str, str], Question], list[str]]:
    """Return the questions that these windows permit, and reasons why others are impossible.

    The key of a question is (split, estimator or score).
    """
    out: dict[tuple[str, str], Question] = {}
    left_out = []
    reference = ESTIMATORS.default
    left_out_material = leave_one_out(data.objects)
    if learns_one_value(left_out_material, data.y):
        left_out.append(
            "Order of hardness by regression: if one of the materials is left out, only one "
            "hardness rank is left for training."
        )
    else:
        out[HELD, "rank"] = Question(
            reference, Task.REGRESSION, data, left_out_material, settings.options(reference)
        )
    unknown = never_learned(left_out_material, data.y)
    if len(unknown):
        left_out.append(
            "Hardness class with a material left out: the ranks "
            f"{', '.join(f'{r:g}' for r in unknown)} have one material each, so no model could be "
            "trained on them without it."
        )
    elif not learns_one_value(left_out_material, data.y):
        for model in _classifiers():
            out[HELD, model] = Question(
                model, Task.CLASSIFICATION, data, left_out_material, settings.options(model)
            )
    if data.has_sessions:
        sessions = by_session(data.sessions, data.y, settings.seed, settings.folds)
        if len(never_learned(sessions, data.y)):
            left_out.append("Hardness class by session: a rank is in sessions of one fold only.")
        else:
            for model in _classifiers():
                options = settings.options(model)
                out[SESSION, model] = Question(model, Task.CLASSIFICATION, data, sessions, options)
    else:
        left_out.append("Hardness class by session: the windows have no two named sessions.")
    if np.unique(data.y, return_counts=True)[1].min() < 2:
        left_out.append("Hardness class in random folds: a rank has a single pinch.")
    else:
        folds = random_folds(data.y, settings.seed)
        options = settings.options(reference)
        out[MIXED, reference] = Question(reference, Task.CLASSIFICATION, data, folds, options)
    return out, left_out


def _classifiers() -> list[str]:
    """Return the names of the classifiers that train quickly, with baselines at the end."""
    able = [
        n for n, e in window_estimators().items() if Task.CLASSIFICATION in e.tasks and not e.slow
    ]
    return sorted(able, key=names.is_baseline)


def _by_material(
    data: LabelledWindows, centroid: Values, predicted: Values | None
) -> dict[str, Material]:
    out = {}
    for material in np.unique(data.objects):
        material_results = data.objects == material
        out[str(material)] = Material(
            rank=float(data.y[material_results].mean()),
            n=int(material_results.sum()),
            centroid_hz=float(centroid[material_results].mean()),
            predicted=None if predicted is None else float(predicted[material_results].mean()),
        )
    return out


def hardness_figure(data: LabelledWindows, centroid: Values) -> Figure:
    materials = sorted(
        set(data.objects.tolist()), key=lambda m: (float(data.y[data.objects == m].mean()), m)
    )
    ranks = np.unique(data.y)
    colours = dict(zip(ranks.tolist(), shades(len(ranks)), strict=True))
    rng = np.random.default_rng(0)
    with canvas(size=(6.2, 1.2 + 0.42 * len(materials))) as (figure, axes):
        ax = axes[0, 0]
        for row, material in enumerate(materials):
            material_results = data.objects == material
            colour = colours[float(data.y[material_results][0])]
            values = centroid[material_results]
            ax.scatter(
                values,
                row + rng.uniform(-0.18, 0.18, len(values)),
                s=16,
                color=colour,
                alpha=0.7,
                lw=0,
            )
            ax.plot([values.mean()] * 2, [row - 0.32, row + 0.32], color=INK, lw=2)
        labels = [
            f"{figure_label(m.replace('_', ' '))}  (rank {data.y[data.objects == m].mean():g})"
            for m in materials
        ]
        ax.set_yticks(range(len(materials)), labels, fontsize=8.5)
        ax.set(
            xlabel="Spectral centroid of the first 15 ms (Hz)", ylim=(-0.6, len(materials) - 0.4)
        )
        ax.grid(axis="y", visible=False)
        image = uri(figure)
    return Figure(
        "hardness",
        "Order of hardness, without training",
        "Each point is a pinch; bars are the means of materials, from which the rank correlation "
        "is computed. The score was chosen before any result was seen: a harder surface is "
        "expected further to the right.",
        image,
    )


HARDNESS = Field.optional("hardness_order", HardnessOrder)
_CLASS: Sequence[Row[ClassificationScores]] = (
    Row("Accuracy", lambda s: bounded(s, "accuracy"), "share"),
    Row("Best constant prediction", lambda s: s.best_constant, "share"),
    Row("Pinches", lambda s: s.n),
)
_ORDER: Sequence[Row[RankCorrelation]] = (
    Row("Spearman ρ", lambda s: s.rho, "rho"),
    Row("Permutation p", lambda s: s.p, "p"),
    Row("Materials", lambda s: s.n),
)


def _text(subjects: Subjects) -> str:
    order = "whether materials come in the right order of hardness"
    if any(results[BLOCKS] or results[OBJECTS] for results in subjects.values()):
        return f"This section uses ranks: {order}. Errors in Shore A are above."
    return f"These labels give no errors in Shore A; they only show {order}."


def order_table(results: SubjectResults) -> Table | None:
    order = results[HARDNESS]
    if not order:
        return None
    left_out = order.leave_one_material_out
    ranks = left_out.rank_regression if left_out else None
    regression = f"{names.estimator(ESTIMATORS.default).title} regression of the rank"
    entries: list[tuple[Cell, RankCorrelation | None, bool]] = [
        (Cell("Nothing learned", order.score), order.spectral_centroid, False),
        (Cell(regression, "material left out"), ranks, False),
    ]
    return matrix("Hardness order from the first 15 ms.", _ORDER, entries)


def class_table(results: SubjectResults) -> Table | None:
    order = results[HARDNESS]
    if not order:
        return None
    entries = [
        (Cell(names.estimator(name).title, "material left out"), scores, names.is_baseline(name))
        for name, scores in order.classes_left_out().items()
    ]
    entries += [
        (Cell(names.estimator(name).title, "session left out"), scores, names.is_baseline(name))
        for name, scores in (order.by_session or {}).items()
    ]
    random = "random folds: the same materials on both sides, so it says little"
    entries += [
        (Cell(names.estimator(name).title, random), scores, True)
        for name, scores in (order.random_folds or {}).items()
    ]
    caption = "Class of hardness."
    if is_learned(results):
        caption += (
            " If a material is left out, the detector that places the windows was trained on it "
            "nevertheless."
        )
    return matrix(caption, _CLASS, entries)


def _rows(subjects: Subjects) -> list[Row[SubjectResults]]:
    def order(value: Callable[[HardnessOrder], Value]) -> Callable[[SubjectResults], Value]:
        return optional(lambda results: results[HARDNESS], value)

    regression = f"Hardness order, {names.estimator(ESTIMATORS.default).title} regression"
    rows = [
        Row("Materials", order(lambda h: h.spectral_centroid.n)),
        Row(
            "Hardness order, spectral centroid: ρ", order(lambda h: h.spectral_centroid.rho), "rho"
        ),
        Row("– its two-sided p", order(lambda h: h.spectral_centroid.p), "p"),
        Row(f"{regression}, material left out: ρ", order(lambda h: h.rho_left_out), "rho"),
    ]
    for name in ESTIMATORS.names:
        title = f"Hardness class, {names.estimator(name).title}"

        def left_out(h: HardnessOrder, name: str = name) -> Value:
            return bounded(h.classes_left_out().get(name), "accuracy")

        def mixed(h: HardnessOrder, name: str = name) -> Value:
            return bounded((h.random_folds or {}).get(name), "accuracy")

        def session(h: HardnessOrder, name: str = name) -> Value:
            return bounded((h.by_session or {}).get(name), "accuracy")

        rows += [
            Row(f"{title}, material left out: accuracy", order(left_out), "share"),
            Row(f"{title}, by session: accuracy", order(session), "share"),
            Row(f"{title}, random folds: accuracy", order(mixed), "share"),
        ]
    constant = order(lambda h: next((s.best_constant for s in h.classes_left_out().values()), None))
    return [*rows, Row("Hardness class, best constant prediction", constant, "share")]


PART = Part(
    "hardness",
    "Order of hardness",
    [Step("hardness order", with_ranks(hardness))],
    _text,
    [order_table, class_table],
    _rows,
)
