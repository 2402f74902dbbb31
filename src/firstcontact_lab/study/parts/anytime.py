"""Estimates at any time after the contact."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from msgspec.structs import asdict

from firstcontact.core import Record, counted, is_same_rate, percent
from firstcontact.models import (
    ESTIMATORS,
    Adapted,
    Bounded,
    Ends,
    InContextModel,
    LabelledTouches,
    adapt_network,
    bounded,
    by_session,
    lengths,
    pretrained,
    regression_scores,
)
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import Figure, PartResult
from firstcontact_lab.report.names import NETWORK_COLOUR, TITLES
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.style import canvas, uri
from firstcontact_lab.report.tables import (
    ABSENT,
    Cell,
    Line,
    Row,
    Table,
    Value,
    format_cell,
    optional,
)
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.part import Part, Step, Subjects
from firstcontact_lab.study.parts.answer_time import before_second, waits
from firstcontact_lab.study.parts.objects import UNSEEN
from firstcontact_lab.study.scores import (
    AnytimeScores,
    anytime_scores,
    join_by_time,
    predictions_by_time,
)
from firstcontact_lab.study.settings import StudySettings
from firstcontact_lab.study.splits import learns_one_value


class FixedWindow(Record, frozen=True, kw_only=True):
    """Error of the default estimator on the same pinches, where they have a whole window."""

    estimator: str
    n: int
    rmse: float
    intervals: dict[str, Ends]


class AnytimeResults(AnytimeScores, frozen=True, kw_only=True):
    """Scores on unseen objects, or on blocks of other sessions (``asked``).

    ``before_second``: share of ``with_second`` pinches of any role with an estimate before the
    second contact, including all delays. ``too_short``: pinches whose second contact came before
    any estimate; they are not scored. ``way``: conditioning scheme. ``level``: nominal coverage of
    the intervals.
    """

    asked: str
    level: float
    way: str
    too_short: int
    before_second: float | None = None
    with_second: int | None = None
    fixed: FixedWindow | None = None
    blocks: AnytimeScores | None = None


_TITLE = "Answers at any time"


def anytime(subject: Subject, settings: StudySettings) -> PartResult:
    """Condition the network on training pinches, and predict unseen objects and other sessions.

    Nothing is trained. Samples from the second contact on are ignored. Pinches whose second contact
    comes before any estimate are counted but not scored.
    """
    model = pretrained()
    rate = subject.dataset.layout.rate
    if not is_same_rate(rate, model.rate):
        return _none(f"the network takes {model.rate:g} Hz and these have {rate:g} Hz")
    if len(subject.levels) < 2:
        return _none("fewer than two Shore A levels to know the rig by")
    labelled = LabelledTouches.cut(subject.dataset, subject.starts)
    home = conditioning_contacts(labelled, subject)
    if home is None:
        return _none("too few contacts were found to know the rig by")
    long_enough = labelled.touches.answerable
    learn = ~subject.dataset.test[labelled.rows]
    objects = labelled.take(long_enough & ~learn)
    adapted = conditioned_model(model, home, settings.seed)
    blocks = _blocks(model, home, settings)
    if len(objects):
        answers = predictions_by_time(adapted.model, objects.touches)
        scores = anytime_scores(answers, objects.shore_a, objects.clusters, settings.seed)
    elif blocks is not None:
        scores = blocks
    else:
        return _none("neither unseen objects nor sessions that could be held out")
    queries = ~learn if len(objects) else learn
    share, of = _before_second(subject, settings.early)
    results = AnytimeResults(
        **asdict(scores),
        asked="objects" if len(objects) else "blocks",
        level=model.level,
        way=adapted.scheme,
        too_short=int((queries & ~long_enough).sum()),
        before_second=share,
        with_second=of,
        fixed=_fixed(subject, objects, settings.seed),
        blocks=blocks if len(objects) else None,
    )
    return PartResult([ANYTIME(results)], [anytime_figure(results)])


def _none(why: str) -> PartResult:
    return PartResult(left_out=[f"{_TITLE}: {why}."])


def conditioning_contacts(labelled: LabelledTouches, subject: Subject) -> LabelledTouches | None:
    """Return the contacts for conditioning the network; None if there are too few."""
    home = labelled.take(labelled.touches.answerable & ~subject.dataset.test[labelled.rows])
    return None if len(home) < 4 or len(np.unique(home.shore_a)) < 2 else home


def conditioned_model(model: InContextModel, home: LabelledTouches, seed: int) -> Adapted:
    """Return the model conditioned on these contacts of the rig."""
    return adapt_network(model, home.touches, home.shore_a, home.named_sessions, seed)


def _blocks(
    model: InContextModel, home: LabelledTouches, settings: StudySettings
) -> AnytimeScores | None:
    """Return the scores on training pinches, with whole sessions held out."""
    if home.named_sessions is None:
        return None
    folds = by_session(home.sessions, home.shore_a, settings.seed, settings.folds)
    if learns_one_value(folds, home.shore_a):
        return None
    parts = []
    for fold in folds:
        selected = conditioned_model(model, home.take(fold.train), settings.seed).model
        parts.append(predictions_by_time(selected, home.take(fold.test).touches))
    order = np.concatenate([fold.test for fold in folds])
    queries = home.take(order)
    return anytime_scores(join_by_time(parts), queries.shore_a, queries.sessions, settings.seed)


def _fixed(subject: Subject, queries: LabelledTouches, seed: int) -> FixedWindow | None:
    """Return the error of the default estimator on the same pinches with a whole window."""
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


def _before_second(subject: Subject, early: float) -> tuple[float | None, int | None]:
    """Return the share of pinches with an estimate before the second contact.

    The first estimate needs the decided contact and the samples of the shortest length.
    """
    dataset = subject.dataset
    if not subject.detections:
        return None, None
    shortest = lengths(dataset.layout.rate)[0]
    return before_second(
        list(
            waits(
                dataset,
                subject.detections,
                lambda pinch, contact: max(contact.decided, contact.sample + shortest - 1),
                early,
            )
        )
    )


_SIDES = {"objects": ("o-", "unseen objects"), "blocks": ("s--", "blocks of other sessions")}


def anytime_figure(results: AnytimeResults) -> Figure:
    """Draw RMSE and mean width by time, with the RMSE of the default estimator."""
    sides: dict[str, AnytimeScores] = {results.asked: results}
    if results.blocks is not None:
        sides["blocks"] = results.blocks
    with canvas(1, 2) as (figure, axes):
        error, width = axes[0]
        for side, scores in sides.items():
            style, name = _SIDES[side]
            _line(error, scores, "rmse", style, name)
            _line(width, scores, "width", style, name)
        fixed = results.fixed
        if fixed is not None:
            look = names.estimator(fixed.estimator)
            label = f"{look.title}, 15 ms, objects"
            error.axhline(fixed.rmse, color=look.colour, ls=":", lw=1.4, label=label)
        error.set(ylabel="RMSE (Shore A)")
        width.set(ylabel=f"Width of the {100 * results.level:g} % interval (Shore A)")
        for ax in (error, width):
            ax.set(xlabel="After contact (ms)", ylim=(0, None), xlim=(0, None))
            ax.set_xticks([float(ms) for ms in results.rmse])
        error.legend(loc="lower left")
        image = uri(figure)
    return Figure(
        "anytime",
        f"Error and interval by the time after contact, {TITLES['in_context']}",
        "No estimate uses signal after its time or after the second contact. Bands are 95 % "
        "bootstrap intervals over specimens or sessions.",
        image,
    )


def _line(ax: Any, scores: AnytimeScores, key: str, style: str, name: str) -> None:
    values: dict[str, float] = getattr(scores, key)
    times = [float(ms) for ms in values]
    ax.plot(times, list(values.values()), style, color=NETWORK_COLOUR, ms=5, label=name)
    ends = scores.intervals.get(key, {})
    if len(ends) == len(values):
        low, high = zip(*(ends[ms] for ms in values), strict=True)
        ax.fill_between(times, low, high, color=NETWORK_COLOUR, alpha=0.15, lw=0)


ANYTIME = Field.optional("anytime", AnytimeResults)
_ASKED = {"objects": "unseen objects", "blocks": "blocks of other sessions"}


def anytime_table(results: SubjectResults) -> Table | None:
    """Return error, coverage, width and share out of range at each time."""
    by_time = results[ANYTIME]
    if by_time is None:
        return None
    lines = _side(by_time, _ASKED[by_time.asked])
    if by_time.fixed is not None:
        title = names.estimator(by_time.fixed.estimator).title
        empty = [Cell(ABSENT)] * (len(by_time.rmse) - 1)
        last = format_cell(bounded(by_time.fixed, "rmse"), "shore")
        lines.insert(1, Line([Cell(f"RMSE, {title}", "whole window"), *empty, last], True))
    if by_time.blocks is not None:
        lines += _side(by_time.blocks, _ASKED["blocks"])
    caption = f"{TITLES['in_context']}: by the time after contact."
    if by_time.before_second is not None:
        caption += (
            " The samples for an estimate lie before the second contact in "
            f"{percent(by_time.before_second)} of {by_time.with_second:,} pinches; computing and "
            "transport are left out."
        )
    caption += (
        f" The network is conditioned on the blocks of the rig ({by_time.way}); "
        f"{counted(by_time.too_short, 'pinch')} whose second contact came before any estimate "
        f"{'is' if by_time.too_short == 1 else 'are'} not scored."
    )
    return Table(caption, ["", *(f"{ms} ms" for ms in by_time.rmse)], lines)


def _side(scores: AnytimeScores, queries: str) -> list[Line]:
    def cells(key: str, unit: str) -> list[Cell]:
        ends, values = scores.intervals.get(key, {}), getattr(scores, key)
        return [format_cell(Bounded(value, ends.get(ms)), unit) for ms, value in values.items()]

    return [
        Line(
            [
                Cell("RMSE, Shore A", f"{queries}, {counted(scores.n, 'pinch')}"),
                *cells("rmse", "shore"),
            ]
        ),
        Line([Cell("Truth in its interval", queries), *cells("coverage", "share")]),
        Line([Cell("Width of it, Shore A", queries), *cells("width", "shore")]),
        Line([Cell("Out of range", queries), *cells("strange", "share")]),
    ]


def _rmse(ms: str) -> Callable[[SubjectResults], Value]:
    def value(by_time: AnytimeResults) -> Value:
        ends = by_time.intervals.get("rmse", {}).get(ms)
        return Bounded(by_time.rmse[ms], ends) if ms in by_time.rmse else None

    return optional(lambda results: results[ANYTIME], value)


BEFORE_SECOND = Row[SubjectResults](
    "Samples for a first estimate before the second contact",
    optional(lambda r: r[ANYTIME], lambda a: a.before_second),
    "share",
    remark="From 2 ms on, by the network that is conditioned on the rig. Computing and cable are "
    "left out.",
    headline=True,
)


def _rows(subjects: Subjects) -> list[Row[SubjectResults]]:
    title = TITLES["in_context"]
    return [
        BEFORE_SECOND,
        *(
            Row(f"Unseen objects, {title}, {ms} ms: RMSE", _rmse(ms), "shore", headline=ms == "5")
            for ms in ("3", "5", "15")
        ),
    ]


PART = Part(
    "anytime",
    "Estimates at any time",
    [
        Step(
            "estimates at any time",
            lambda subject, settings, runner: anytime(subject, settings),
            cost=4,
        )
    ],
    lambda subjects: (
        "One pre-trained network, conditioned on the rig by its own block pinches, predicts at "
        "any moment; nothing is trained here. Later signal is not used, nor any after the second "
        "contact."
    ),
    [anytime_table],
    _rows,
)
