"""Study part ``in_force``: errors of the last estimate before the second finger touches."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FileError, Record
from firstcontact.core.files import read_regular
from firstcontact.core.records import LONGEST, Name, read_record
from firstcontact.models import Touches
from firstcontact.models.labelled_data import LabelledTouches
from firstcontact.models.scores import Ends, regression_scores
from firstcontact.models.training_runs import RIG_ESTIMATOR
from firstcontact.models.values import Values
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import PartResult, missing
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.tables import Cell, Row, Table, bounded, matrix, optional
from firstcontact_lab.study.detection_scores import resampler_lookahead
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject, Subjects

_Ascending = Annotated[
    tuple[Annotated[float, msgspec.Meta(ge=0, le=1e4)], ...],
    msgspec.Meta(min_length=1, max_length=100_000),
]


class LiveDelays(msgspec.Struct, frozen=True):
    machine: Name
    first_ms: _Ascending
    later_ms: _Ascending

    def quantiles(self, shares: Values, *, is_first: bool) -> Values:
        """Return quantiles of the delay of estimates that was measured in live sessions, s.

        With ``is_first`` they are for the first estimate of a closing, otherwise for later
        estimates. ``shares`` are from 0 to 1.
        """
        delays = self.first_ms if is_first else self.later_ms
        return np.asarray(1e-3 * np.quantile(delays, shares))


def read_delays(path: Path) -> LiveDelays:
    remedy = "give the file of `benchmarks/live.py --out`"
    delays = read_record(read_regular(path, LONGEST), LiveDelays, str(path), remedy)
    for name, values in (("first_ms", delays.first_ms), ("later_ms", delays.later_ms)):
        if np.any(np.diff(values) < 0):
            raise FileError(f"{name} in {path} must ascend: {remedy}")
    return delays


class InForce(Record, frozen=True, kw_only=True):
    estimator: str
    share: float
    with_second: int
    n: int
    rmse: float | None = None
    intervals: dict[str, Ends] = msgspec.field(default_factory=dict)
    signal_ms: float | None = None
    machine: str
    first_ms: float
    later_ms: float


_TITLE = "Estimate in force"


def in_force(subject: Subject, settings: StudySettings) -> PartResult:
    if not settings.delays:
        return (
            missing(f"{_TITLE}: give a file with --delays.")
            if "in_force" in settings.parts
            else PartResult()
        )
    if not subject.detections or subject.adapted is None:
        return missing(
            f"{_TITLE}: contacts are not detected, or no model is conditioned on the pinches."
        )
    delays = read_delays(Path(settings.delays))
    has_second = np.array([p.second is not None for p in subject.dataset.pinches])
    if not has_second.any():
        return missing(f"{_TITLE}: no pinch has a known second contact.")
    samples = last_samples(subject, delays, settings.seed)
    labelled = LabelledTouches.cut(subject.dataset, subject.detections)
    objects = labelled.take(subject.dataset.test[labelled.rows] & (samples[labelled.rows] > 0))
    last = samples[objects.rows]
    value, elapsed = np.full((2, len(objects)), np.nan)
    for n in np.unique(last):
        predicted = subject.adapted.model.predict_touches(objects.touches.take(last == n).until(n))
        value[last == n], elapsed[last == n] = predicted.value, predicted.elapsed
    middle = np.array(0.5)
    results = InForce(
        estimator=RIG_ESTIMATOR.name,
        share=float(np.mean(samples[has_second] > 0)),
        with_second=int(has_second.sum()),
        n=len(objects),
        machine=delays.machine,
        first_ms=1e3 * float(delays.quantiles(middle, is_first=True)),
        later_ms=1e3 * float(delays.quantiles(middle, is_first=False)),
    )
    if len(objects):
        scores = regression_scores(
            objects.shore_a, value, objects.bootstrap_clusters, settings.seed
        )
        results = msgspec.structs.replace(
            results,
            rmse=scores.rmse,
            intervals={key: ends for key, ends in scores.intervals.items() if key == "rmse"},
            signal_ms=1e3 * float(np.median(elapsed)),
        )
    return PartResult([IN_FORCE(results)])


def last_samples(subject: Subject, delays: LiveDelays, seed: int) -> NDArray[np.intp]:
    """Return the signal length of the last estimate before the second contact, in samples.

    The result has one entry per pinch. It is 0 for a pinch without such an estimate. Each closing
    gets random delays.
    """
    dataset = subject.dataset
    rate = dataset.layout.rate
    waited = resampler_lookahead(dataset)
    quantile = np.random.default_rng(seed).random(len(dataset))
    first, later = (delays.quantiles(quantile, is_first=is_first) for is_first in (True, False))
    out = np.zeros(len(dataset), np.intp)
    for row, (pinch, contact) in enumerate(zip(dataset.pinches, subject.detections, strict=True)):
        if contact is None or pinch.second is None:
            continue
        offset = (pinch.second.sample - contact.sample) / rate - waited
        decided = (contact.decided - contact.sample) / rate
        delay = first[row]
        for n in Touches.all_lengths(rate):
            if max((n - 1) / rate, decided) + delay < offset:
                out[row] = n
            if (n - 1) / rate >= decided:  # the first estimate of the closing is out
                delay = later[row]
    return out


IN_FORCE = Field.optional("in_force", InForce)


def _text(subjects: Subjects) -> str:
    text = "The last estimate that is available when the second finger touches."
    for results in subjects.values():
        if scores := results[IN_FORCE]:
            return (
                f"{text} Detection counts, and so do waiting, transport and computing: "
                f"{scores.first_ms:.1f} ms at first, later {scores.later_ms:.1f} ms (medians on "
                f"{scores.machine})."
            )
    return text


_COLUMNS: tuple[Row[InForce], ...] = (
    Row("Pinches with an estimate", lambda scores: scores.share, "share"),
    Row("RMSE, unseen objects", lambda scores: bounded(scores, "rmse"), "shore"),
    Row("Scored pinches", lambda scores: scores.n),
    Row("Signal, median", lambda scores: scores.signal_ms, "ms"),
)


def in_force_table(results: SubjectResults) -> Table | None:
    scores = results[IN_FORCE]
    if scores is None:
        return None
    title = names.estimator(scores.estimator).title
    return matrix("Estimates in force.", _COLUMNS, [(Cell(title), scores, False)])


def _rows(subjects: Subjects) -> list[Row[SubjectResults]]:
    return [
        Row(
            "Pinches with an estimate in force at the second contact",
            optional(lambda results: results[IN_FORCE], lambda scores: scores.share),
            "share",
            headline=True,
        ),
        Row(
            "Unseen objects, estimate in force: RMSE",
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
    ("Pinches with an estimate", "RMSE, unseen objects"),
    needs=("anytime",),
)
