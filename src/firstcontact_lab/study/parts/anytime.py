"""Study part ``anytime``: scores of any-time estimators at several times after the contact."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from msgspec import field
from msgspec.structs import asdict

from firstcontact.core import Record
from firstcontact.core.physics import is_same_rate
from firstcontact.core.text import counted, percent
from firstcontact.jobs import Runner
from firstcontact.models import ESTIMATORS, Predictions, Touches
from firstcontact.models.labelled_data import LabelledTouches
from firstcontact.models.model_file import pretrained
from firstcontact.models.predictions import TouchPredictor
from firstcontact.models.rig.network_estimator import Adapted, NetworkEstimator, rig_estimators
from firstcontact.models.scores import Ends, regression_scores
from firstcontact.models.splits import Split, by_session
from firstcontact.models.training_runs import RIG_ESTIMATOR
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import Figure, PartResult, missing
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.style import banded_line, canvas, uri
from firstcontact_lab.report.tables import (
    ABSENT,
    Bounded,
    Cell,
    Line,
    Row,
    Table,
    Value,
    bounded,
    format_cell,
    optional,
)
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject, Subjects, titled
from firstcontact_lab.study.parts.answer_time import before_second, wait_times
from firstcontact_lab.study.parts.objects import UNSEEN
from firstcontact_lab.study.scores import (
    AnytimeScores,
    anytime_scores,
    join_by_time,
    learns_one_value,
    predictions_by_time,
)
from firstcontact_lab.study.window_ladder import fit_window_ladder


class FixedWindow(Record, frozen=True, kw_only=True):
    estimator: str
    n: int
    rmse: float
    intervals: dict[str, Ends]


class OtherScores(Record, frozen=True, kw_only=True):
    unseen: AnytimeScores = field(name="asked")
    blocks: AnytimeScores | None = None


class AnytimeResults(AnytimeScores, frozen=True, kw_only=True):
    """Scores of ``estimator`` on unseen objects, by time after the contact.

    For a dataset without unseen objects, they are scores on held-out sessions.
    """

    pinches: str = field(name="asked")
    level: float
    scheme: str = field(name="way")
    too_short: int
    before_second: float | None = None
    with_second: int | None = None
    fixed: FixedWindow | None = None
    blocks: AnytimeScores | None = None
    estimator: str = "network"
    other_estimators: dict[str, OtherScores] | None = field(default=None, name="others")

    def by_estimator(self) -> dict[str, OtherScores]:
        return {
            self.estimator: OtherScores(unseen=self, blocks=self.blocks),
            **(self.other_estimators or {}),
        }


_TITLE = "Estimates at any time"


def anytime(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    model = pretrained()
    rate = subject.dataset.layout.rate
    if not is_same_rate(rate, model.rate):
        return missing(
            f"{_TITLE}: the network takes {model.rate:g} Hz, but the pinches have {rate:g} Hz."
        )
    if len(subject.levels) < 2:
        return missing(
            f"{_TITLE}: conditioning needs training pinches of two Shore A levels or more."
        )
    labelled = LabelledTouches.cut(subject.dataset, subject.starts)
    home = conditioning_contacts(labelled, subject)
    if home is None:
        return missing(f"{_TITLE}: too few contacts were found for conditioning.")
    long_enough = labelled.touches.answerable
    learn = ~subject.dataset.test[labelled.rows]
    objects = labelled.take(long_enough & ~learn)
    folds = _folds(home, settings)
    if not folds and not len(objects):
        return missing(
            f"{_TITLE}: there are no unseen objects, and no sessions that could be held out."
        )
    # The job with all contacts takes the longest, and goes first.
    everyone = np.arange(len(home))
    splits = [Split("all", everyone, everyone[:0]), *folds]
    regressors = [name for name in ESTIMATORS.names if ":" in name]  # of ``study --estimator``
    predicted = runner.map(_predict, splits, home, objects, settings.seed, regressors)
    adapted, on_objects = predicted[0]
    assert adapted is not None
    subject.adapted = adapted
    by_estimator = {}
    for name in (*rig_estimators(), *regressors):
        on_blocks = [by_name[name] for _, by_name in predicted[1:]]
        blocks = _block_scores(on_blocks, folds, home, settings.seed) if folds else None
        if len(objects):
            truth, clusters = objects.shore_a, objects.bootstrap_clusters
            unseen = anytime_scores(on_objects[name], truth, clusters, settings.seed)
            by_estimator[name] = OtherScores(unseen=unseen, blocks=blocks)
        elif blocks is not None:
            by_estimator[name] = OtherScores(unseen=blocks)
    scores = by_estimator.pop(RIG_ESTIMATOR.name)
    queries = ~learn if len(objects) else learn
    share, of = known_before_second(subject, settings.early)
    results = AnytimeResults(
        **asdict(scores.unseen),
        pinches="objects" if len(objects) else "blocks",
        level=model.level,
        scheme="each finger" if adapted.by_finger else "one",
        too_short=int((queries & ~long_enough).sum()),
        before_second=share,
        with_second=of,
        fixed=_fixed(subject, objects, settings.seed),
        blocks=scores.blocks,
        estimator=RIG_ESTIMATOR.name,
        other_estimators=by_estimator,
    )
    return PartResult([ANYTIME(results)])


def conditioning_contacts(labelled: LabelledTouches, subject: Subject) -> LabelledTouches | None:
    """Return the training contacts on which the network is conditioned, or None for too few."""
    home = labelled.take(labelled.touches.answerable & ~subject.dataset.test[labelled.rows])
    return None if len(home) < 4 or len(np.unique(home.shore_a)) < 2 else home


def conditioned_model(estimator: str, home: LabelledTouches, seed: int) -> Adapted:
    adapt = rig_estimators()[estimator].adapt
    return adapt(pretrained(), home.touches, home.shore_a, home.named_sessions, seed)


def _folds(home: LabelledTouches, settings: StudySettings) -> list[Split]:
    if home.named_sessions is None:
        return []
    folds = by_session(home.sessions, home.shore_a, settings.seed, settings.folds)
    return [] if learns_one_value(folds, home.shore_a) else folds


def _predict(
    split: Split,
    home: LabelledTouches,
    objects: LabelledTouches,
    seed: int,
    regressors: Sequence[str],
) -> tuple[Adapted | None, dict[str, Mapping[int, Predictions]]]:
    """Adapt all estimators to the training side of a split, and predict its test side.

    Return (adapted default model, predictions by estimator and time in ms). If the split has no
    test side, predict ``objects``.
    """
    learned = home.take(split.train)
    queries = home.take(split.test) if len(split.test) else objects
    adapted = conditioned_model(RIG_ESTIMATOR.name, learned, seed)
    # The default estimator contains the network, conditioned on the same contacts.
    models: dict[str, TouchPredictor] = {
        NetworkEstimator.name: adapted.model.network_alone(),
        RIG_ESTIMATOR.name: adapted.model,
    }
    for name in rig_estimators():
        if name not in models:
            models[name] = conditioned_model(name, learned, seed).model
    if not len(queries):
        return adapted, {}
    for name in regressors:
        models[name] = fit_window_ladder(
            name, learned.touches, learned.shore_a, learned.sessions, seed=seed
        )
    return None if len(split.test) else adapted, {
        name: predictions_by_time(model, queries.touches) for name, model in models.items()
    }


def _block_scores(
    predictions: Sequence[Mapping[int, Predictions]],
    folds: Sequence[Split],
    home: LabelledTouches,
    seed: int,
) -> AnytimeScores:
    queries = home.take(np.concatenate([fold.test for fold in folds]))
    return anytime_scores(join_by_time(predictions), queries.shore_a, queries.sessions, seed)


def _fixed(subject: Subject, queries: LabelledTouches, seed: int) -> FixedWindow | None:
    """Return the error of the default window estimator, or None if no window is complete."""
    name = ESTIMATORS.default
    if (name, UNSEEN) not in subject.predictions:
        return None
    data, predicted = subject.predictions[name, UNSEEN]
    same = np.isfinite(predicted) & np.isin(data.rows, queries.rows)
    if not same.any():
        return None
    selected = data.take(same)
    scores = regression_scores(selected.y, predicted[same], selected.specimens, seed)
    return FixedWindow(
        estimator=name, n=scores.n, rmse=scores.rmse, intervals={
            key: ends for key, ends in scores.intervals.items() if key == "rmse"
        },
    )  # fmt: skip


def known_before_second(subject: Subject, early: float) -> tuple[float | None, int | None]:
    """Return (share of pinches with an estimate before the second contact, number of pinches).

    Only pinches for which this is known count. Without such pinches, both are None. Labels may be
    up to ``early`` s too late.
    """
    dataset = subject.dataset
    if not subject.detections:
        return None, None
    shortest = Touches.lengths(dataset.layout.rate)[0]
    return before_second(
        list(
            wait_times(
                dataset,
                subject.detections,
                lambda pinch, contact: max(contact.decided, contact.sample + shortest - 1),
                early,
            )
        )
    )


_SCHEMES = {"one": "one context for all fingers", "each finger": "one context for each finger"}
_SIDES = {"objects": ("o-", "unseen objects"), "blocks": ("s--", "blocks of other sessions")}


def anytime_figure(results: AnytimeResults) -> Figure:
    appearance = names.estimator(results.estimator)
    sides: dict[str, AnytimeScores] = {results.pinches: results}
    if results.blocks is not None:
        sides["blocks"] = results.blocks
    with canvas(1, 2) as (figure, axes):
        error, width = axes[0]
        for side, scores in sides.items():
            style, name = _SIDES[side]
            _line(error, scores, "rmse", style, name, appearance.colour)
            _line(width, scores, "width", style, name, appearance.colour)
        fixed = results.fixed
        if fixed is not None:
            other = names.estimator(fixed.estimator)
            label = f"{other.title}, 15 ms, objects"
            error.axhline(fixed.rmse, color=other.colour, ls=":", lw=1.4, label=label)
        error.set(ylabel="RMSE (Shore A)")
        width.set(ylabel=f"Width of the {100 * results.level:g} % interval (Shore A)")
        for ax in (error, width):
            ax.set(xlabel="After contact (ms)", ylim=(0, None), xlim=(0, None))
            ax.set_xticks([float(ms) for ms in results.rmse])
        error.legend(loc="lower left")
        image = uri(figure)
    return Figure(
        "anytime",
        f"Error and interval by the time after contact: {appearance.title.lower()}",
        "No estimate uses signal after its time or after the second contact. Bands are 95 % "
        "intervals.",
        image,
    )


def _line(ax: Any, scores: AnytimeScores, key: str, style: str, name: str, colour: str) -> None:
    values: dict[str, float] = getattr(scores, key)
    ends = scores.intervals.get(key, {})
    times = [float(ms) for ms in values]
    banded_line(
        ax, times, list(values.values()), [ends.get(ms) for ms in values], style, colour, name
    )


ANYTIME = Field.optional("anytime", AnytimeResults)


def anytime_table(results: SubjectResults) -> Table | None:
    by_time = results[ANYTIME]
    if by_time is None:
        return None
    lines = [
        _error_line(by_time, _SIDES[by_time.pinches][1]),
        Line([Cell("Coverage of the interval"), *_cells(by_time, "coverage", "share")]),
        Line(
            [
                Cell("Width of the interval, Shore A"),
                *(format_cell(width, "shore") for width in by_time.width.values()),
            ]
        ),
    ]
    if by_time.fixed is not None:
        title = names.estimator(by_time.fixed.estimator).title
        empty = [Cell(ABSENT)] * (len(by_time.rmse) - 1)
        last = format_cell(bounded(by_time.fixed, "rmse"), "shore")
        lines.insert(1, Line([Cell(f"RMSE, {title}", "whole window"), *empty, last], True))
    caption = f"{names.estimator(by_time.estimator).title}, by time after contact."
    if by_time.before_second is not None:
        caption += (
            f" In {percent(by_time.before_second)} of {by_time.with_second:,} pinches the samples "
            "for a first estimate lie before the second contact, not counting computing and "
            "transport."
        )
    caption += (
        " The model is conditioned on the blocks of the rig "
        f"({_SCHEMES.get(by_time.scheme, by_time.scheme)}). Not scored: "
        f"{counted(by_time.too_short, 'pinch')} whose second contact came before any estimate."
    )
    return Table(caption, ["", *(f"{ms} ms" for ms in by_time.rmse)], lines)


def others_table(results: SubjectResults) -> Table | None:
    by_time = results[ANYTIME]
    if by_time is None:
        return None
    lines = []
    for name, scores in by_time.by_estimator().items():
        title = names.estimator(name).title
        if name != by_time.estimator:
            lines.append(_error_line(scores.unseen, f"{title}, {_SIDES[by_time.pinches][1]}"))
        if scores.blocks is not None:
            lines.append(_error_line(scores.blocks, f"{title}, {_SIDES['blocks'][1]}"))
    caption = "Blocks of other sessions, and other estimators."
    return Table(caption, ["", *(f"{ms} ms" for ms in by_time.rmse)], lines) if lines else None


def _cells(scores: AnytimeScores, key: str, unit: str) -> list[Cell]:
    ends, values = scores.intervals.get(key, {}), getattr(scores, key)
    return [format_cell(Bounded(value, ends.get(ms)), unit) for ms, value in values.items()]


def _error_line(scores: AnytimeScores, queries: str) -> Line:
    small = f"{queries}, {counted(scores.n, 'pinch')}"
    return Line([Cell("RMSE, Shore A", small), *_cells(scores, "rmse", "shore")])


def _rmse(estimator: str, ms: str) -> Callable[[SubjectResults], Value]:
    def value(by_time: AnytimeResults) -> Value:
        entry = by_time.by_estimator().get(estimator)
        # Without unseen objects the scores are of blocks, to which the row does not apply.
        if by_time.pinches != "objects" or entry is None or ms not in entry.unseen.rmse:
            return None
        return Bounded(entry.unseen.rmse[ms], entry.unseen.intervals.get("rmse", {}).get(ms))

    return optional(lambda results: results[ANYTIME], value)


BEFORE_SECOND = Row[SubjectResults](
    "Pinches with enough signal for a first estimate before the second contact",
    optional(lambda r: r[ANYTIME], lambda a: a.before_second),
    "share",
)


def _rows(subjects: Subjects) -> list[Row[SubjectResults]]:
    by_subject = [by_time for results in subjects.values() if (by_time := results[ANYTIME])]
    default = by_subject[0].estimator if by_subject else RIG_ESTIMATOR.name
    return [
        BEFORE_SECOND,
        *(
            Row(
                f"Unseen objects, {names.estimator(name).title}, {ms} ms: RMSE",
                _rmse(name, ms),
                "shore",
                headline=ms == "5" and name == default,
            )
            for name in dict.fromkeys((default, *rig_estimators()))
            for ms in ("3", "5", "15")
        ),
    ]


PART = Part(
    "anytime",
    "Estimates at any time",
    [Step("estimates at any time", anytime, cost=4)],
    lambda subjects: (
        "One pre-trained network, conditioned on block pinches of the rig, predicts at any time. "
        "Its prediction is averaged with that of a regression on the same pinches."
    ),
    [anytime_table, others_table],
    _rows,
    figures=lambda subjects: titled(subjects, ANYTIME, anytime_figure),
)
