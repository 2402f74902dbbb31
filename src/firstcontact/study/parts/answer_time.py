"""When a stiffness could be told, and whether the other finger had touched by then."""

from __future__ import annotations

import numpy as np
from msgspec.structs import asdict

from firstcontact.core import Contact, Pinch
from firstcontact.learning.detection import quantiles, resampler_lookahead, right_and_not_early
from firstcontact.learning.training import DURATION
from firstcontact.report.findings import PartResult
from firstcontact.report.results.contact import Answers, AnswerTimes
from firstcontact.report.results.study import SubjectResults
from firstcontact.signal import Conditioner, contact_windows, samples_in
from firstcontact.study._subject import Subject
from firstcontact.study.settings import StudySettings


def answer_time(subject: Subject, settings: StudySettings) -> PartResult:
    """Time from the known contact to a complete window, for each window length.

    A window answers when it is complete after the filter's look-ahead and the
    contact has been decided, whichever is later; the resampler's look-ahead is
    added. The arithmetic of the estimate is not in it, nor is transport. A
    pinch has an answer where the first trigger is the right finger's, not early
    and followed by a whole window. Pinches without one count as not answered
    before the second contact.
    """
    known = [i for i, p in enumerate(subject.dataset.pinches) if p.first is not None]
    if known and not subject.found:
        return PartResult(
            left_out=["Time to an answer: windows start at the known contacts, not at found ones."]
        )
    if not known:
        return PartResult(left_out=["Time to an answer: no pinch has a known first contact."])
    by_length = {
        duration: _at(subject, duration, settings.early)
        for duration in sorted({*settings.durations, DURATION})
    }
    lengths = {f"{1e3 * duration:g}": scores for duration, scores in by_length.items()}
    times = AnswerTimes(**asdict(by_length[DURATION]), window_length_ms=lengths)
    return PartResult(SubjectResults(answer_ms=times))


def answered(pinch: Pinch, contact: Contact, duration: float) -> int:
    """Number of the sample after whose arrival the window from a contact is known."""
    layout = pinch.layout
    last = contact.sample + samples_in(duration, layout.rate) - 1
    return max(contact.decided, last + Conditioner(layout).lookahead)


def _at(subject: Subject, duration: float, early: float) -> Answers:
    dataset = subject.dataset
    whole = contact_windows(dataset, subject.found, duration)[1]
    waited = resampler_lookahead(dataset)
    after, in_time, of, with_second = [], 0, 0, 0
    for pinch, contact, complete in zip(dataset.pinches, subject.found, whole, strict=True):
        truth, rate = pinch.first, pinch.layout.rate
        if truth is None:
            continue
        of += 1
        with_second += pinch.offset is not None
        if contact is None or not complete:
            continue
        if not right_and_not_early(contact, truth, rate, early):
            continue
        seconds = (answered(pinch, contact, duration) - truth.sample) / rate + waited
        after.append(1e3 * seconds)
        in_time += pinch.offset is not None and seconds < pinch.offset
    delays = quantiles(np.array(after)) if after else None
    return Answers(
        n=len(after),
        of=of,
        median=delays.median if delays else None,
        p95=delays.p95 if delays else None,
        before_second=in_time / with_second if with_second else None,
        with_second=with_second or None,
    )
