"""Estimate in force: the last one that is available when the second finger touches."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np

from firstcontact.core import LONGEST, InputError, Name, Record, read_record, read_regular
from firstcontact.models import (
    RIG_ESTIMATOR,
    Ends,
    LabelledTouches,
    Values,
    bounded,
    regression_scores,
    resampler_lookahead,
)
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.tables import Cell, Row, Table, matrix, optional
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.part import Part, Step, Subjects
from firstcontact_lab.study.parts.answer_time import before_second
from firstcontact_lab.study.parts.anytime import first_answers
from firstcontact_lab.study.scores import predictions_by_time
from firstcontact_lab.study.settings import StudySettings

#: Times after the contact at which `live` predicts, ms.
_TIMES = range(2, 16)


class Delays(msgspec.Struct, frozen=True):
    """Measured delays of live estimates, and the machine that they were measured on.

    Parameters
    ----------
    machine
        Name of the processor.
    delays_ms
        Quantiles of the delay, ms, in ascending order: from the last sample that an estimate needs
        until it is available. The first is the smallest delay, and the last the largest.
    """

    machine: Name
    delays_ms: Annotated[
        tuple[Annotated[float, msgspec.Meta(ge=0, le=1e4)], ...],
        msgspec.Meta(min_length=2, max_length=10_000),
    ]

    def draw(self, n: int, rng: np.random.Generator) -> Values:
        """Return random delays, s, shape (n,)."""
        shares = np.linspace(0, 1, len(self.delays_ms))
        return np.asarray(1e-3 * np.interp(rng.random(n), shares, self.delays_ms))

    def quantile(self, share: float) -> float:
        """Return a quantile of the delay, ms."""
        return float(np.quantile(self.delays_ms, share))


def read_delays(path: Path) -> Delays:
    """Return the delays in a ``live.json``.

    Raises
    ------
    InputError
        The file has another format, or its delays do not ascend.
    """
    remedy = "give the file of `benchmarks/live.py --out`"
    delays = read_record(read_regular(path, LONGEST), Delays, str(path), remedy)
    if np.any(np.diff(delays.delays_ms) < 0):
        raise InputError(f"{path}: delays_ms do not ascend: {remedy}")
    return delays


class InForce(Record, frozen=True, kw_only=True):
    """Share of pinches with an estimate in force, and its error on ``n`` unseen objects' pinches.

    ``share``: share of the ``with_second`` pinches that had an estimate in force. ``machine``:
    machine of the measured delays, with median ``delay_p50_ms`` and ``delay_p99_ms``.
    ``signal_ms``: median length of the signal in the estimates.
    """

    estimator: str
    share: float
    with_second: int
    n: int
    rmse: float
    intervals: dict[str, Ends]
    signal_ms: float
    machine: str
    delay_p50_ms: float
    delay_p99_ms: float


_TITLE = "Estimate in force"


def in_force(subject: Subject, settings: StudySettings) -> PartResult:
    """Score the last estimates that were available before the second contact.

    An estimate is available when its samples have arrived, the contact is detected, and a measured
    delay has passed. Each estimate gets a random one of these delays.
    """
    if not settings.delays:
        return PartResult()
    if not subject.detections or subject.adapted is None:
        return _none("contacts are not detected, or no model is conditioned on the pinches")
    delays = read_delays(Path(settings.delays))
    rng = np.random.default_rng(settings.seed)
    answers = first_answers(subject, settings.early)
    late = delays.draw(len(answers), rng)
    share, with_second = before_second(
        [
            (pinch, None if seconds is None else seconds + delay)
            for (pinch, seconds), delay in zip(answers, late.tolist(), strict=True)
        ]
    )
    labelled = LabelledTouches.cut(subject.dataset, subject.detections)
    objects = labelled.take(labelled.touches.answerable & subject.dataset.test[labelled.rows])
    offsets, decided = _times(subject, objects)
    value, elapsed = np.full((2, len(objects)), np.nan)
    model = subject.adapted.model
    for ms, predicted in predictions_by_time(model, objects.touches, _TIMES).items():
        available = np.maximum(1e-3 * ms, decided) + delays.draw(len(objects), rng)
        is_in_time = available < offsets
        value[is_in_time] = predicted.value[is_in_time]
        elapsed[is_in_time] = predicted.elapsed[is_in_time]
    has_value = np.isfinite(value)
    if share is None or with_second is None or not has_value.any():
        return _none("no unseen object's pinch has one and a known second contact")
    scores = regression_scores(
        objects.shore_a[has_value], value[has_value], objects.clusters[has_value], settings.seed
    )
    results = InForce(
        estimator=RIG_ESTIMATOR.name,
        share=share,
        with_second=with_second,
        n=scores.n,
        rmse=scores.rmse,
        intervals={key: ends for key, ends in scores.intervals.items() if key == "rmse"},
        signal_ms=1e3 * float(np.median(elapsed[has_value])),
        machine=delays.machine,
        delay_p50_ms=delays.quantile(0.5),
        delay_p99_ms=delays.quantile(0.99),
    )
    return PartResult([IN_FORCE(results)])


def _none(why: str) -> PartResult:
    return PartResult(left_out=[f"{_TITLE}: {why}."])


def _times(subject: Subject, objects: LabelledTouches) -> tuple[Values, Values]:
    """Return the times from each detected contact to the second one and to the decision, s.

    The first is NaN if the second contact is unknown. Both allow for the resampler's delay.
    """
    offsets, decided = np.full((2, len(objects)), np.nan)
    waited = resampler_lookahead(subject.dataset)
    for place, row in enumerate(objects.rows):
        pinch, contact = subject.dataset.pinches[row], subject.detections[row]
        assert contact is not None
        rate = pinch.layout.rate
        decided[place] = (contact.decided - contact.sample) / rate
        if pinch.second is not None:
            offsets[place] = (pinch.second.sample - contact.sample) / rate - waited
    return offsets, decided


IN_FORCE = Field.optional("in_force", InForce)


def _text(subjects: Subjects) -> str:
    text = "The last estimate that is available when the second finger touches."
    for results in subjects.values():
        if scores := results[IN_FORCE]:
            return (
                f"{text} Detection counts, and so do waiting, transport and computing: "
                f"{scores.delay_p50_ms:.1f} ms (median) and {scores.delay_p99_ms:.1f} ms (99 %), "
                f"measured in live sessions on {scores.machine}."
            )
    return text


_COLUMNS: tuple[Row[InForce], ...] = (
    Row("Pinches with an estimate", lambda scores: scores.share, "share"),
    Row("RMSE, unseen objects", lambda scores: bounded(scores, "rmse"), "shore"),
    Row("Scored pinches", lambda scores: scores.n),
    Row("Signal, median", lambda scores: scores.signal_ms, "ms"),
    Row("Delay, median", lambda scores: scores.delay_p50_ms, "ms"),
    Row("Delay, 99 %", lambda scores: scores.delay_p99_ms, "ms"),
)


def in_force_table(results: SubjectResults) -> Table | None:
    """Return a table of the share of pinches with an estimate in force, its error and delays."""
    scores = results[IN_FORCE]
    if scores is None:
        return None
    title = names.estimator(scores.estimator).title
    return matrix("Estimates in force.", _COLUMNS, [(Cell(title), scores, False)])


def _rows(subjects: Subjects) -> list[Row[SubjectResults]]:
    return [
        Row(
            "Pinches with an estimate when the second finger touches",
            optional(lambda results: results[IN_FORCE], lambda scores: scores.share),
            "share",
            remark="First estimate at 2 ms. Measured delays of `live` are counted.",
            headline=True,
        ),
        Row(
            "Unseen objects, this estimate: RMSE",
            lambda results: bounded(results[IN_FORCE], "rmse"),
            "shore",
            headline=True,
        ),
    ]


PART = Part(
    "in_force",
    _TITLE,
    [Step("estimate in force", lambda subject, settings, runner: in_force(subject, settings))],
    _text,
    [in_force_table],
    _rows,
    columns=(
        "Pinches with an estimate",
        "RMSE, unseen objects",
        "Scored pinches",
        "Signal, median",
    ),
    needs=("anytime",),
)
