"""When a stiffness could be told, and whether the other finger had touched by then."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from msgspec.structs import asdict

from firstcontact.core import Contact, Dataset, Pinch
from firstcontact.models import DURATION, quantiles, resampler_lookahead, right_and_not_early
from firstcontact.signal import Conditioner, contact_windows, samples_in
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.results.contact import Answers, AnswerTimes
from firstcontact_lab.report.results.study import SubjectResults
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.settings import StudySettings


def answer_time(subject: Subject, settings: StudySettings) -> PartResult:
    """Time from the known contact to a complete window, for each window length.

    A window answers when it is complete after the filter's look-ahead and the
    contact has been decided, whichever is later; the resampler's look-ahead is
    added. The arithmetic of the estimate is not in it, nor is transport. A
    pinch has an answer where the first trigger is the right finger's, not early
    and followed by a whole window. Pinches without one count as not answered. So
    ``before_second`` is of samples, and not the "in time" of live output.
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


def waits(
    dataset: Dataset,
    contacts: Sequence[Contact | None],
    known: Callable[[Pinch, Contact], int],
    early: float,
) -> Iterator[tuple[Pinch, float | None]]:
    """How long after its true first contact each pinch that has one is answered for, s.

    The resampler's look-ahead is added. A contact that is another finger's, or early, is no
    answer: None.

    Parameters
    ----------
    dataset, contacts
        The pinches, and the contacts to answer about; None where there is nothing to answer.
    known
        Number of the sample with which the answer about a contact is known.
    early
        So much before the true one a contact may be placed, s.
    """
    waited = resampler_lookahead(dataset)
    for pinch, contact in zip(dataset.pinches, contacts, strict=True):
        truth, rate = pinch.first, pinch.layout.rate
        if truth is None:
            continue
        if contact is None or not right_and_not_early(contact, truth, rate, early):
            yield pinch, None
        else:
            yield pinch, (known(pinch, contact) - truth.sample) / rate + waited


def before_second(answers: Sequence[tuple[Pinch, float | None]]) -> tuple[float | None, int | None]:
    """Return the share of pinches with samples for an answer before the second contact.

    The second number is of how many pinches. None where no pinch has a second contact.
    """
    both = [(p.offset, seconds) for p, seconds in answers if p.offset is not None]
    early = sum(seconds is not None and seconds < offset for offset, seconds in both)
    return (early / len(both), len(both)) if both else (None, None)


def _at(subject: Subject, duration: float, early: float) -> Answers:
    dataset = subject.dataset
    whole = contact_windows(dataset, subject.found, duration)[1]
    asked = [c if complete else None for c, complete in zip(subject.found, whole, strict=True)]
    answers = list(waits(dataset, asked, lambda p, c: answered(p, c, duration), early))
    after = [1e3 * seconds for _, seconds in answers if seconds is not None]
    delays = quantiles(np.array(after)) if after else None
    share, with_second = before_second(answers)
    return Answers(
        n=len(after),
        of=len(answers),
        median=delays.median if delays else None,
        p95=delays.p95 if delays else None,
        before_second=share,
        with_second=with_second,
    )
