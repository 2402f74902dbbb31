"""Study part ``answer_time``: time from the contact to a complete window."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from msgspec.structs import asdict

from firstcontact.core import Contact, Dataset, Pinch, Record
from firstcontact.models.labelled_data import DURATION
from firstcontact.signal import samples_in
from firstcontact.signal.windowing import Conditioner
from firstcontact_lab.report.findings import PartResult, missing
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.tables import Cell, Row, Table, matrix, optional
from firstcontact_lab.study.detection_scores import (
    quantiles,
    resampler_lookahead,
    right_and_not_early,
)
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject, Subjects
from firstcontact_lab.study.parts.contacts import Accepted
from firstcontact_lab.study.parts.data import is_twin


class Answers(Record, frozen=True, kw_only=True):
    n: int
    of: int
    median: float | None = None
    p95: float | None = None
    before_second: float | None = None
    with_second: int | None = None


class AnswerTimes(Answers, frozen=True, kw_only=True):
    """Times from contact to estimate, ms, for the default window length and for other lengths."""

    window_length_ms: dict[str, Answers]


def answer_time(subject: Subject, settings: StudySettings) -> PartResult:
    """Measure the time from the true contact to a complete window, for each window length."""
    answer_sample = [i for i, p in enumerate(subject.dataset.pinches) if p.first is not None]
    if answer_sample and not subject.detections:
        return missing(
            "Time to an estimate: windows start at known contacts, not at detected ones."
        )
    if not answer_sample:
        return missing("Time to an estimate: no pinch has a known first contact.")
    by_length = {
        duration: _times(subject, duration, settings.early)
        for duration in sorted({*settings.durations, DURATION})
    }
    lengths = {f"{1e3 * duration:g}": scores for duration, scores in by_length.items()}
    times = AnswerTimes(**asdict(by_length[DURATION]), window_length_ms=lengths)
    return PartResult([ANSWER(times)])


def answered(pinch: Pinch, contact: Contact, duration: float) -> int:
    """Return the number of the sample at which a window of ``duration`` s is complete."""
    layout = pinch.layout
    last = contact.sample + samples_in(duration, layout.rate) - 1
    return max(contact.decided, last + Conditioner(layout).lookahead)


def wait_times(
    dataset: Dataset,
    contacts: Sequence[Contact | None],
    answer_sample: Callable[[Pinch, Contact], int],
    early: float,
) -> Iterator[tuple[Pinch, float | None]]:
    """Yield each pinch that has a known true contact, with the time to its estimate, s.

    The time starts at the true contact. It is None if the detected contact is wrong or missing.
    ``answer_sample`` returns the sample that completes the estimate. Labels may be up to ``early``
    s too late.
    """
    waited = resampler_lookahead(dataset)
    for pinch, contact in zip(dataset.pinches, contacts, strict=True):
        truth, rate = pinch.first, pinch.layout.rate
        if truth is None:
            continue
        if contact is None or not right_and_not_early(contact, truth, rate, early):
            yield pinch, None
        else:
            yield pinch, (answer_sample(pinch, contact) - truth.sample) / rate + waited


def before_second(answers: Sequence[tuple[Pinch, float | None]]) -> tuple[float | None, int | None]:
    """Return (share of pinches with an estimate before the second contact, number of pinches).

    Only pinches with a known second contact count. Without such pinches, both are None.
    """
    both = [(p.offset, seconds) for p, seconds in answers if p.offset is not None]
    early = sum(seconds is not None and seconds < offset for offset, seconds in both)
    return (early / len(both), len(both)) if both else (None, None)


def _times(subject: Subject, duration: float, early: float) -> Answers:
    dataset = subject.dataset
    is_complete = subject.cut_windows(duration, subject.detections)[1]
    contacts = [
        c if complete else None for c, complete in zip(subject.detections, is_complete, strict=True)
    ]
    answers = list(wait_times(dataset, contacts, lambda p, c: answered(p, c, duration), early))
    delays_ms = [1e3 * seconds for _, seconds in answers if seconds is not None]
    delays = quantiles(np.array(delays_ms)) if delays_ms else None
    share, with_second = before_second(answers)
    return Answers(
        n=len(delays_ms),
        of=len(answers),
        median=delays.median if delays else None,
        p95=delays.p95 if delays else None,
        before_second=share,
        with_second=with_second,
    )


ANSWER = Field.optional("answer_ms", AnswerTimes)
_TIMES: Sequence[Row[Answers]] = (
    Row("Median", lambda answers: answers.median, "ms"),
    Row("95th percentile", lambda answers: answers.p95, "ms"),
    Row("Samples before second contact", lambda answers: answers.before_second, "share"),
    Row("Estimates", lambda answers: answers.n),
)


def _text(subjects: Subjects) -> str:
    place = (
        "label of the first contact" if Accepted.from_results(subjects).early else "first contact"
    )
    answers = (results[ANSWER] for results in subjects.values())
    if any(times and times.with_second for times in answers):
        return f"Windows from the {place} that are complete before the other finger touches."
    return f"Time from the {place} to a complete window."


def answer_table(results: SubjectResults) -> Table | None:
    times = results[ANSWER]
    if not times:
        return None
    lengths = sorted(times.window_length_ms.items(), key=lambda item: float(item[0]))
    place = Accepted.from_results({"": results}).place
    caption = (
        f"Time from the {place} to a complete window. It includes the wait for the decision and "
        "the look-ahead of the filters, but not computing and transport. A pinch whose first "
        "trigger is missed, early or on the wrong finger has no estimate."
    )
    if is_twin(results):
        caption += " Twin results."
    entries = (
        (Cell(f"{ms} ms window", f"of {answers.of:,}"), answers, False) for ms, answers in lengths
    )
    return matrix(caption, _TIMES, entries)


def _rows(subjects: Subjects) -> list[Row[SubjectResults]]:
    label = (
        "label of the first contact" if Accepted.from_results(subjects).early else "first contact"
    )
    return [
        Row(
            f"From the {label} to the end of a 15 ms window, median",
            optional(lambda r: r[ANSWER], lambda a: a.median),
            "ms",
        ),
        Row(
            "15 ms window complete before the second contact",
            optional(lambda r: r[ANSWER], lambda a: a.before_second),
            "share",
        ),
    ]


PART = Part(
    "answer",
    "Time to an estimate",
    [Step("time to an estimate", lambda subject, settings, runner: answer_time(subject, settings))],
    _text,
    [answer_table],
    _rows,
    ("Samples before second contact",),
)
