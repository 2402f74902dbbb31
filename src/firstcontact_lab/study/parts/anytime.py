"""Answers at any time after the contact: by when, how far off, and how sure."""

from __future__ import annotations

import numpy as np
from msgspec.structs import asdict

from firstcontact.core import is_same_rate
from firstcontact.models import (
    ESTIMATORS,
    TIMES,
    Adapted,
    Answers,
    AnytimeScores,
    InContextModel,
    LabelledTouches,
    adapt_network,
    answers_by_time,
    anytime_scores,
    by_session,
    joined_answers,
    learns_one_value,
    lengths,
    pretrained,
    regression_scores,
)
from firstcontact_lab.report.figures.anytime import anytime_figure
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.results.anytime import AnytimeResults, FixedWindow
from firstcontact_lab.report.results.study import SubjectResults
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.parts.answer_time import before_second, waits
from firstcontact_lab.study.parts.objects import UNSEEN
from firstcontact_lab.study.settings import StudySettings

_TITLE = "Answers at any time"


def anytime(subject: Subject, settings: StudySettings) -> PartResult:
    """Know the rig by the pinches to learn from; ask about unseen objects and other sessions.

    Nothing is trained. Samples from the second contact on are not looked at. Pinches whose
    second contact comes before any answer are counted and not scored.
    """
    model = pretrained()
    rate = subject.dataset.layout.rate
    if not is_same_rate(rate, model.rate):
        return _none(f"the network takes {model.rate:g} Hz and these have {rate:g} Hz")
    if len(subject.levels) < 2:
        return _none("fewer than two Shore A levels to know the rig by")
    known = LabelledTouches.of(subject.dataset, subject.starts)
    home = home_of(known, subject)
    if home is None:
        return _none("too few contacts were found to know the rig by")
    long_enough = known.touches.answerable
    learn = ~subject.dataset.test[known.which]
    objects = known.take(long_enough & ~learn)
    adapted = conditioned_on(model, home, settings.seed)
    blocks = _blocks(model, home, settings)
    if len(objects):
        answers = answers_by_time(adapted.model, objects.touches)
        scores = anytime_scores(answers, objects.shore_a, objects.clusters, settings.seed)
    elif blocks is not None:
        scores = blocks
    else:
        return _none("neither unseen objects nor sessions that could be held out")
    asked = ~learn if len(objects) else learn
    share, of = _before_second(subject, settings.early)
    found = AnytimeResults(
        **asdict(scores),
        asked="objects" if len(objects) else "blocks",
        level=model.level,
        way=adapted.way,
        too_short=int((asked & ~long_enough).sum()),
        before_second=share,
        with_second=of,
        fixed=_fixed(subject, objects, settings.seed),
        blocks=blocks if len(objects) else None,
    )
    return PartResult(SubjectResults(anytime=found), [anytime_figure(found)])


def _none(why: str) -> PartResult:
    return PartResult(left_out=[f"{_TITLE}: {why}."])


def home_of(known: LabelledTouches, subject: Subject) -> LabelledTouches | None:
    """Those of these contacts that the rig is known by; None where they are too few."""
    home = known.take(known.touches.answerable & ~subject.dataset.test[known.which])
    return None if len(home) < 4 or len(np.unique(home.shore_a)) < 2 else home


def conditioned_on(model: InContextModel, home: LabelledTouches, seed: int) -> Adapted:
    """The model that knows the rig by these contacts."""
    return adapt_network(model, home.touches, home.shore_a, home.named_sessions, seed)


def _blocks(
    model: InContextModel, home: LabelledTouches, settings: StudySettings
) -> AnytimeScores | None:
    """Scores of the pinches to learn from, with whole sessions held out."""
    if home.named_sessions is None:
        return None
    folds = by_session(home.sessions, home.shore_a, settings.seed, settings.folds)
    if learns_one_value(folds, home.shore_a):
        return None
    by_time: dict[int, list[Answers]] = {ms: [] for ms in TIMES}
    for fold in folds:
        its = conditioned_on(model, home.take(fold.train), settings.seed).model
        for ms, answers in answers_by_time(its, home.take(fold.test).touches).items():
            by_time[ms].append(answers)
    order = np.concatenate([fold.test for fold in folds])
    joined = {ms: joined_answers(parts) for ms, parts in by_time.items()}
    asked = home.take(order)
    return anytime_scores(joined, asked.shore_a, asked.sessions, settings.seed)


def _fixed(subject: Subject, asked: LabelledTouches, seed: int) -> FixedWindow | None:
    """The default estimator on those of these pinches that it has a whole window of."""
    name = ESTIMATORS.default
    if (name, UNSEEN) not in subject.predictions:
        return None
    data, predicted = subject.predictions[name, UNSEEN]
    same = np.isfinite(predicted) & np.isin(data.which, asked.which)
    if not same.any():
        return None
    its = data.take(same)
    scores = regression_scores(its.y, predicted[same], its.specimens, seed)
    return FixedWindow(
        estimator=name, n=scores.n, rmse=scores.rmse, intervals={
            key: ends for key, ends in scores.intervals.items() if key == "rmse"
        },
    )  # fmt: skip


def _before_second(subject: Subject, early: float) -> tuple[float | None, int | None]:
    """Return the share of pinches with samples for an answer before the second contact.

    The first answer comes when the contact has been decided and the shortest length is there,
    whichever is later.
    """
    dataset = subject.dataset
    if not subject.found:
        return None, None
    shortest = lengths(dataset.layout.rate)[0]
    return before_second(
        list(
            waits(
                dataset,
                subject.found,
                lambda pinch, contact: max(contact.decided, contact.sample + shortest - 1),
                early,
            )
        )
    )
