"""Contacts from the columns of a table, and assumptions if columns are missing."""

import numpy as np
import pytest

from firstcontact.core import Contact, Finger, InputError
from firstcontact.recording import make_layout
from firstcontact.recording._checks import read_settings
from firstcontact.recording._labels import make_contacts, make_labels

RATE = 4936.0
SETTINGS = read_settings("x", {"sample_rate_hz": RATE, "piezo_unit": "V"})
ONE, TWO = (make_layout(SETTINGS, sensors) for sensors in (1, 2))


def two_fingers(
    seed: int, first_finger: Finger, first_sample: int, second_sample: int
) -> np.ndarray:
    """Return noise on both channels, and a step response on each after its finger touches."""
    piezo = np.random.default_rng(seed).normal(0, 0.01, (300, 2))
    # The fingers' gains differ, so the larger trace is not always the livelier one.
    piezo[:, 1] *= 20
    for finger, start in ((first_finger, first_sample), (first_finger.other, second_sample)):
        t = np.arange(300 - start) / RATE
        gain = 20 if finger is Finger.THUMB else 1
        piezo[start:, finger] += gain * np.sin(2 * np.pi * 80 * t) * np.exp(-t / 0.01)
    return piezo


@pytest.mark.parametrize("finger", Finger)
@pytest.mark.parametrize("unknown", [{}, {"first_finger": [-1]}, {"first_finger": [""]}])
def test_unknown_first_finger_is_estimated_with_a_note(finger, unknown):
    piezo = two_fingers(1, finger, 150, 180)
    columns = {"first_contact": [150], "second_contact": [180], **unknown}
    contacts, notes = make_contacts("x", columns, [piezo], TWO)
    assert contacts == [(Contact(finger, 150, 150), Contact(finger.other, 180, 180))]
    assert len(notes) == 1
    assert "first_finger of 1 pinches is not known" in notes[0]


def test_given_first_finger_is_used():
    piezo = two_fingers(2, Finger.INDEX, 150, 180)
    columns = {"first_contact": [150], "first_finger": ["thumb"]}
    contacts, notes = make_contacts("x", columns, [piezo], TWO)
    assert contacts == [(Contact(Finger.THUMB, 150, 150),)]
    assert notes == []


def test_one_channel_belongs_to_the_touching_finger():
    columns = {"first_contact": [20, 20], "first_finger": [0, 1]}
    contacts, notes = make_contacts("x", columns, [np.zeros((60, 1))] * 2, ONE)
    assert contacts == [(Contact(Finger.INDEX, 20, 20),)] * 2
    assert len(notes) == 1
    assert "one channel" in notes[0]


@pytest.mark.parametrize("number", [int, float, np.int16, np.float32, np.float64])
def test_whole_numbers_of_any_type_are_equal_labels(number):
    columns = {
        "specimen": [number(1), number(-20)],
        "session": [number(0), number(10**4)],
        "first_contact": [number(20), number(20)],
        "first_finger": [number(1), number(-1)],
    }
    labels, _ = make_labels("x", columns, 2)
    assert [(x.specimen, x.session) for x in labels] == [("1", "0"), ("-20", "10000")]
    piezo = two_fingers(1, Finger.INDEX, 20, 40)
    contacts, _ = make_contacts("x", columns, [piezo] * 2, TWO)
    assert [c.finger for (c,) in contacts] == [Finger.THUMB, Finger.INDEX]


def test_numbers_with_a_fraction_keep_it():
    labels, _ = make_labels("x", {"specimen": [1.5, 0.1]}, 2)
    assert [x.specimen for x in labels] == ["1.5", "0.1"]
    with pytest.raises(InputError, match="first_finger"):
        make_contacts("x", {"first_contact": [1], "first_finger": [0.5]}, [np.zeros((9, 2))], TWO)


def test_no_contact_needs_no_finger():
    columns = {"first_contact": [-1]}
    assert make_contacts("x", columns, [np.zeros((60, 2))], TWO) == ([()], [])


@pytest.mark.parametrize(
    ("alpha", "rate", "note_count"), [(0.5, 4936, 0), (1, 9000, 0), (0.9, 4936, 1), (0.5, 16000, 1)]
)
def test_smoothing_unlike_the_device_adds_a_note(alpha, rate, note_count):
    fields = {"sample_rate_hz": rate, "piezo_unit": "V", "smoothing_alpha": alpha}
    assert len(read_settings("x", fields).notes) == note_count
