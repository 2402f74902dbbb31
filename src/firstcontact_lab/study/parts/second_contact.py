"""Error of estimates from windows that contain the second contact, and from other windows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Record
from firstcontact.models.scores import RegressionScores, regression_scores
from firstcontact.models.training import DURATION
from firstcontact.models.window_model import Values
from firstcontact.signal import samples_in
from firstcontact.signal.windowing import Conditioner
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import PartResult, missing
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.tables import Cell, Row, Table, bounded, matrix
from firstcontact_lab.study.detection_scores import outcome
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject
from firstcontact_lab.study.parts.blocks import SESSION
from firstcontact_lab.study.parts.objects import PUBLISHED, UNSEEN


class SecondContact(Record, frozen=True, kw_only=True):
    """Errors by group of windows."""

    blocks: dict[str, RegressionScores] | None = None
    objects: dict[str, RegressionScores] | None = None


def by_side(
    scores_by_side: Mapping[str, SecondContact],
) -> list[tuple[str, str, str, RegressionScores]]:
    """Return estimator, "blocks" or "objects", group of windows, and errors of each group."""
    sides = [("blocks", model, side_scores.blocks) for model, side_scores in scores_by_side.items()]
    sides += [("objects", model, scores.objects) for model, scores in scores_by_side.items()]
    return [
        (model, side, content, scores)
        for side, model, side_scores in sides
        for content, scores in (side_scores or {}).items()
    ]


def second_contact(subject: Subject, settings: StudySettings) -> PartResult:
    room = samples_to_spare(subject)
    astray = misplaced(subject, settings.early)
    if not np.isfinite(room).any():
        return missing("Second contact in the window: second contacts are not known.")
    scores_by_side: dict[str, dict[str, dict[str, RegressionScores]]] = {}
    for (model, split), (data, predicted) in subject.predictions.items():
        side = {SESSION: "blocks", UNSEEN: "objects"}.get(split)
        if side is None or names.is_baseline(model):
            continue
        samples_left = room[data.rows]
        is_scored = np.isfinite(predicted) & np.isfinite(samples_left)
        clusters = data.clusters if side == "blocks" else data.specimens
        wrong = astray[data.rows]
        for name, chosen in (
            ("with", is_scored & ~wrong & (samples_left < 0)),
            ("without", is_scored & ~wrong & (samples_left >= 0)),
            ("misplaced", is_scored & wrong),
        ):
            if chosen.any():
                scores = regression_scores(
                    data.y[chosen], predicted[chosen], clusters[chosen], settings.seed
                )
                scores_by_side.setdefault(model, {}).setdefault(side, {})[name] = scores
    if not scores_by_side:
        return missing("Second contact in the window: no split by session or of unseen objects.")
    sides = {model: SecondContact(**side_scores) for model, side_scores in scores_by_side.items()}
    return PartResult([SECOND_CONTACT(sides)])


def misplaced(subject: Subject, early: float) -> NDArray[np.bool_]:
    """Return a mask of pinches whose window does not begin at their first contact."""
    pairs = zip(subject.dataset.pinches, subject.starts, strict=True)
    return np.array(
        [
            pinch.first is not None
            and outcome(start, pinch.first, pinch.layout.rate, early) != "success"
            for pinch, start in pairs
        ],
        dtype=np.bool_,
    )


def samples_to_spare(subject: Subject) -> Values:
    """Return the number of samples from each window's end to the second contact."""
    out = np.full(len(subject.dataset), np.nan)
    for i, (pinch, start) in enumerate(zip(subject.dataset.pinches, subject.starts, strict=True)):
        if pinch.second is not None and start is not None:
            # The filter also uses the samples just after the window.
            ahead = Conditioner(pinch.layout).lookahead
            end = start.sample + samples_in(DURATION, pinch.layout.rate) + ahead
            out[i] = pinch.second.sample - end
    return out


SECOND_CONTACT = Field.optional("second_contact_in_window", dict[str, SecondContact])
_SCORES: Sequence[Row[RegressionScores]] = (
    Row("RMSE", lambda s: bounded(s, "rmse"), "shore"),
    Row("Pinches", lambda s: s.n),
)


def second_table(results: SubjectResults) -> Table | None:
    divided = results[SECOND_CONTACT]
    entries = [
        (Cell(f"{side.capitalize()}, {names.estimator(name).title}, {content}"), scores, False)
        for name, side, content, scores in by_side(divided or {})
        if name in PUBLISHED
    ]
    return matrix(
        "Windows with or without the second contact, and misplaced windows, which do not begin at "
        "the first contact; Shore A.",
        _SCORES,
        entries,
    )


PART = Part(
    "second",
    "Second contact in the window",
    [
        Step(
            "second contact",
            lambda subject, settings, runner: second_contact(subject, settings),
            late=True,
        )
    ],
    tables=[second_table],
    needs=("blocks", "objects"),
)
