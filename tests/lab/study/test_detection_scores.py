"""Scores of contact detection from known decisions."""

import numpy as np
import pytest

from firstcontact.contact.contacts import PinchDecisions
from firstcontact.contact.detector import WindowDecisions
from firstcontact.core import Contact, Dataset, Finger, InputError, Pinch, fingertip_layout
from firstcontact.signal.resampling import lookahead
from firstcontact_lab.study.detection_scores import score_decisions

LAYOUT = fingertip_layout()
STEP = 15
#: Ends of the windows; the contact at 300 shows first in the one that ends at 314.
ENDS = np.arange(14, 600, STEP)
TRUTH = 300


def decisions(*firings: tuple[int, Finger, int]) -> PinchDecisions:
    """Return decisions that fire as given: end of the window, finger, and onset."""
    fired = np.zeros((len(ENDS), 2), dtype=np.bool_)
    onsets = np.full((len(ENDS), 2), -1)
    for end, finger, onset in firings:
        row = int(np.searchsorted(ENDS, end))
        fired[row, finger] = True
        onsets[row, finger] = onset
    windows = WindowDecisions(ENDS, fired, onsets)
    contacts = [Contact(finger, onset, end) for end, finger, onset in firings]
    first = min(contacts, key=lambda contact: (contact.decided, contact.sample), default=None)
    return PinchDecisions(windows, windows, first)


def score_all(dataset: Dataset, *firings: tuple[int, Finger, int], **settings: float):
    """Score the same decisions for each pinch."""
    judged = [decisions(*firings)] * len(dataset)
    return score_decisions(judged, dataset, 0.003, **settings)


def pinch(truth: int | None = TRUTH) -> Pinch:
    contacts = () if truth is None else (Contact(Finger.THUMB, truth, truth),)
    return Pinch(np.zeros((600, 16), dtype=np.int16), LAYOUT, truth=contacts)


def score(*firings, n: int = 1, **settings):
    return score_all(Dataset((pinch(),) * n), *firings, **settings)


GOOD = (314, Finger.THUMB, 302)


def test_a_perfect_detector():
    scores = score(GOOD, n=3)
    assert (scores.n, scores.windows) == (3, 3 * (2 * 20 + 1))
    assert (scores.quiet_windows, scores.too_soon) == (3 * 2 * 20, 0)
    assert scores.window_accuracy == scores.pinch_success == 1.0
    assert scores.false_alarms_per_minute == 0.0
    assert scores.median_delay == pytest.approx(1e3 * 14 / 4936)


@pytest.mark.parametrize(
    ("firings", "outcome"),
    [
        ([], "misses"),
        ([(200, Finger.THUMB, 195), GOOD], "false_alarms"),
        ([(200, Finger.INDEX, 195), GOOD], "false_alarms"),
        ([(314, Finger.INDEX, 305)], "wrong_finger"),
        ([(314, Finger.INDEX, 301), GOOD], "wrong_finger"),
        ([(359, Finger.THUMB, 340)], "late"),
    ],
)
def test_each_way_to_fail(firings, outcome):
    scores = score(*firings)
    assert scores.pinch_success == scores.decided_within_3_ms == 0.0
    assert getattr(scores, outcome) == 1
    assert scores.median_delay == (pytest.approx(1e3 * 59 / 4936) if outcome == "late" else None)


def test_placed_in_time_is_not_decided_in_time():
    # The contact is at 300: 14 samples later are 2.8 ms, 29 are 5.9 ms.
    assert score((314, Finger.THUMB, 302)).decided_within_3_ms == 1.0
    slow = score((329, Finger.THUMB, 302))
    assert (slow.pinch_success, slow.decided_within_3_ms) == (1.0, 0.0)
    assert slow.median_delay == pytest.approx(1e3 * 29 / 4936)


def test_a_trigger_before_the_contact_is_not_decided_in_time():
    # It places the contact 2.8 ms too early, which is near enough, but fires before it.
    lucky = score((299, Finger.THUMB, 286), GOOD)
    assert (lucky.pinch_success, lucky.decided_within_3_ms) == (1.0, 0.0)
    assert lucky.delay_ms is None
    # Where the contact may be that much before its label, it is in time.
    allowed = score((299, Finger.THUMB, 286), GOOD, early=1 / 4936)
    assert allowed.decided_within_3_ms == 1.0
    assert allowed.median_delay == pytest.approx(-1e3 / 4936)


def test_what_the_resampler_waits_for_is_in_the_delay():
    dataset = Dataset((pinch(),), recorded_rate=44_100.0)
    scores = score_all(dataset, GOOD)
    waited = 1e3 * lookahead(44_100.0, 4936.0)
    assert 0.3 < waited <= 0.5
    assert scores.lookahead_ms == pytest.approx(waited)
    assert scores.median_delay == pytest.approx(1e3 * 14 / 4936 + waited)
    assert (scores.pinch_success, scores.decided_within_3_ms) == (1.0, 0.0)
    assert score(GOOD).lookahead_ms is None


def test_the_earlier_onset_of_one_window_is_the_first_trigger():
    assert score((314, Finger.INDEX, 306), GOOD).pinch_success == 1.0


@pytest.mark.parametrize(("onset", "right"), [(286, 1.0), (314, 1.0), (285, 0.0), (315, 0.0)])
def test_three_milliseconds_before_or_late(onset, right):
    assert score((329, Finger.THUMB, onset)).pinch_success == right


def test_window_accuracy_counts_quiet_and_one_contact_window():
    silent = score()
    assert silent.quiet_windows_silent == 1.0
    assert silent.contact_windows_found == 0.0
    assert silent.window_accuracy == pytest.approx(40 / 41)
    two_wrong = score((200, Finger.THUMB, 190), (200, Finger.INDEX, 190), GOOD)
    assert two_wrong.window_accuracy == pytest.approx(39 / 41)
    # What comes after the contact's window counts no more.
    assert score(GOOD, (359, Finger.INDEX, 350)).window_accuracy == 1.0


def test_a_contact_too_young_may_show_or_not():
    # It shows 1 ms (5 samples) in the window after the one that ends at 299.
    young = Dataset((pinch(297),))
    for firings in ((), ((299, Finger.THUMB, 298),)):
        scores = score_all(young, *firings, (314, Finger.THUMB, 298))
        assert scores.window_accuracy == 1.0
        assert scores.windows == 2 * 19 + 1


def test_a_contact_before_the_first_window_is_too_soon_to_be_counted() -> None:
    for truth, soon in ((0, 0), (-1, 1), (-200, 1)):
        cut = pinch(0)  # cut where the steady state begins, it keeps an earlier contact
        object.__setattr__(cut, "truth", (Contact(Finger.THUMB, truth, truth),))
        scores = score_all(Dataset((cut, pinch())), GOOD)
        assert (scores.n, scores.too_soon) == (2, soon)
        assert scores.contact_windows_found == (1.0 if soon else 0.5)


def test_false_alarms_are_runs_per_minute_of_listening():
    run = [(end, Finger.THUMB, end) for end in (104, 119, 134)]
    scores = score(*run, (254, Finger.INDEX, 250))
    listened = 20 * STEP / 4936 / 60
    assert scores.false_alarms_per_minute == pytest.approx(2 / listened)


def test_labels_that_may_be_late_leave_a_span_out():
    in_span = (284, Finger.THUMB, 275)
    assert score(in_span).pinch_success == 0.0
    lenient = score(in_span, early=0.005)
    assert lenient.pinch_success == 1.0
    assert lenient.quiet_windows_silent == 1.0
    assert lenient.median_delay < 0


def test_pinches_without_truth_are_left_out_with_a_note():
    scores = score_all(Dataset((pinch(), pinch(None))), GOOD)
    assert (scores.n, scores.left_out) == (1, 1)
    with pytest.raises(InputError, match="no pinch has a known first contact"):
        score_all(Dataset((pinch(None),)))


def test_looks_of_a_step_count_as_one_window() -> None:
    """Otherwise a detector with shorter steps could not be compared with the published shares."""
    fine = np.arange(2, 600, 3)
    fired = np.zeros((len(fine), 2), dtype=np.bool_)
    fired[np.searchsorted(fine, 101) : np.searchsorted(fine, 107), Finger.INDEX] = True
    fired[np.searchsorted(fine, TRUTH + 8), Finger.THUMB] = True
    windows = WindowDecisions(fine, fired, np.where(fired, fine[:, None], -1))
    judged = PinchDecisions(windows, windows, Contact(Finger.INDEX, 101, 101))
    scores = score_decisions([judged], Dataset((pinch(),)), 3 / LAYOUT.rate)
    assert (scores.quiet_windows, scores.windows) == (2 * 20, 2 * 20 + 1)
    assert scores.quiet_windows_silent == pytest.approx(39 / 40)
    assert scores.contact_windows_found == 1.0
