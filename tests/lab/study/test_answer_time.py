"""Time to a complete window, compared with closed forms. The pinches' samples do not matter."""

from dataclasses import replace

import numpy as np
import pytest

from firstcontact.core import Contact, Dataset, Finger, Pinch, fingertip_layout
from firstcontact.signal.resampling import lookahead
from firstcontact_lab.report.results import NOTHING
from firstcontact_lab.study.part import StudySettings, Subject
from firstcontact_lab.study.parts.answer_time import ANSWER, answer_time

RATE = 4936.0
FIRST = 600
#: 15 ms are 74 samples, the last is number 73; the filter looks two ahead.
WHOLE = 73 + 2


def pinch(offset: int | None) -> Pinch:
    data = np.random.default_rng(0).normal(16384, 30, (900, 16)).astype(np.int16)
    truth = [Contact(Finger.THUMB, FIRST, FIRST)]
    if offset is not None:
        truth.append(Contact(Finger.INDEX, FIRST + offset, FIRST + offset))
    return Pinch(data, fingertip_layout(), truth=tuple(truth))


def detection(sample: int, decided: int, finger: Finger = Finger.THUMB) -> Contact:
    return Contact(finger, FIRST + sample, FIRST + decided)


def answer(*cases: tuple[int | None, Contact | None], rate: float | None = None, **settings):
    dataset = Dataset(tuple(pinch(offset) for offset, _ in cases), recorded_rate=rate)
    subject = Subject("any", dataset, tuple(contact for _, contact in cases))
    return answer_time(subject, replace(StudySettings(), **settings)).results[ANSWER]


def test_a_window_waits_for_its_end_and_the_filter():
    scores = answer((None, detection(3, 12)))
    assert scores.median == scores.p95 == pytest.approx(1e3 * (3 + WHOLE) / RATE)
    assert (scores.n, scores.of) == (1, 1)
    assert scores.before_second is None


def test_before_the_second_contact_excludes_equality():
    late, in_time = (WHOLE, detection(0, 12)), (WHOLE + 1, detection(0, 12))
    assert answer(late, in_time).before_second == 0.5


def test_what_is_no_answer_counts_against():
    cases = [
        None,
        detection(0, 12, Finger.INDEX),
        detection(-40, -30),
        detection(250, 290),
        detection(0, 12),
    ]
    scores = answer(*((200, case) for case in cases))
    # Missed, wrong, early, without a whole window; only the last is an answer.
    assert (scores.n, scores.of, scores.with_second) == (1, 5, 5)
    assert scores.before_second == pytest.approx(1 / 5)


def test_resampling_delay_is_awaited():
    # The second contact comes a sample after the window is complete.
    late = round(answer((80, detection(0, 12))).median * RATE / 1e3) + 1
    base, waited = answer((late, detection(0, 12))), answer((late, detection(0, 12)), rate=44_100.0)
    assert waited.median - base.median == pytest.approx(1e3 * lookahead(44_100.0, RATE))
    assert (base.before_second, waited.before_second) == (1.0, 0.0)


def test_without_known_contacts_it_is_left_out():
    blind = replace(pinch(None), truth=())
    outcome = answer_time(Subject("any", Dataset((blind,)), (None,)), StudySettings())
    assert outcome.results is NOTHING
    assert "Time to an estimate" in outcome.left_out[0]
