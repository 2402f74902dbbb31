"""What every registered detector promises; a new one is tested by registering it."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from closings import LAYOUT, SAMPLES, closing, closings
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from firstcontact.contact import detect
from firstcontact.core import Block, Finger, InputError, Layout, Pinch
from firstcontact.signal import samples_in

split = st.lists(st.integers(0, SAMPLES), max_size=20)
STEADY = samples_in(0.040, LAYOUT.rate)


def constant(value: int, n: int = SAMPLES) -> Pinch:
    return Pinch(np.full((n, 16), value, dtype=np.int16), LAYOUT)


def feed(detector, pinch, edges, **change):
    return [
        contact
        for a, b in pairwise(edges)
        for contact in detector.update(Block(pinch.data[a:b], pinch.first_sample + a, **change))
    ]


def test_names_itself_and_its_times(detector):
    assert detector.duration == 0.020
    assert detector.step == 0.003
    assert isinstance(detector.name, str)


def test_finds_some_contacts_where_they_are(detector):
    right = 0
    for pinch in closings(20, seed=3).pinches:
        contacts = detect(detector, pinch)
        right += bool(contacts) and abs(contacts[0].sample - pinch.first.sample) <= 15
    assert right >= 4  # also true of the threshold, which clicks set off


@given(cuts=split, seed=st.integers(0, 50))
@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_any_split_gives_the_same_contacts(detector, cuts, seed):
    pinch = closing(seed)
    whole = detect(detector, pinch)
    detector.start(LAYOUT)
    assert feed(detector, pinch, [0, *sorted(cuts), SAMPLES]) == whole


def test_sample_by_sample_is_the_same(detector):
    pinch = closing(5)
    whole = detect(detector, pinch)
    detector.start(LAYOUT)
    assert feed(detector, pinch, range(SAMPLES + 1)) == whole


def test_nothing_after_the_deciding_sample_matters(detector):
    for seed in range(5):
        pinch = closing(seed)
        for contact in detect(detector, pinch):
            cut = contact.decided + 1 - pinch.first_sample
            known = detect(detector, replace(pinch, data=pinch.data[:cut]))
            assert contact in known
            assert contact not in detect(detector, replace(pinch, data=pinch.data[: cut - 1]))


def test_onset_lies_in_the_deciding_window(detector):
    for pinch in closings(10, seed=4).pinches:
        for contact in detect(detector, pinch):
            age = (contact.decided - contact.sample) / LAYOUT.rate
            assert 0 <= age <= detector.duration


def test_each_finger_is_latched_until_start(detector):
    pinch = closing(3)
    contacts = detect(detector, pinch)
    fingers = [c.finger for c in contacts]
    assert fingers
    assert len(fingers) == len(set(fingers))
    again = Block(pinch.data, pinch.first_sample + SAMPLES)
    assert all(c.finger not in fingers for c in detector.update(again))
    assert detect(detector, pinch) == contacts


def test_sample_numbers_only_shift_the_answer(detector):
    pinch = closing(6)
    far = 2**40
    moved = detect(detector, replace(pinch, first_sample=far))
    for a, b in zip(detect(detector, pinch), moved, strict=True):
        assert (b.finger, b.sample - a.sample) == (a.finger, far - pinch.first_sample)
        assert b.decided - a.decided == far - pinch.first_sample


@pytest.mark.parametrize("change", [{"epoch": 1}, {"first_sample": 10**6}])
def test_no_window_across_a_gap(detector, change):
    # Loud after the gap, quiet before: a window across it would show a contact.
    quiet = closing(7, touches=False).data
    loud = ((quiet.astype(np.int32) - 16384) * 30 + 16384).clip(0, 32736).astype(np.int16)
    detector.start(LAYOUT)
    before = detector.judge(Block(quiet, 0))
    after = replace(Block(loud, SAMPLES), **change)
    verdicts = detector.judge(after)
    assert before.ends.max() < SAMPLES
    first = verdicts.ends.min() - samples_in(detector.duration, LAYOUT.rate) + 1
    assert first >= after.first_sample
    assert verdicts.ends.min() >= after.first_sample + STEADY


def test_windows_cover_every_sample_once_as_new(detector):
    detector.start(LAYOUT)
    verdicts = detector.judge(Block(closing(8).data, 500))
    step = samples_in(detector.step, LAYOUT.rate)
    assert verdicts.ends[0] == 500 + STEADY + step - 1
    assert set(np.diff(verdicts.ends)) == {step}
    assert verdicts.fired.shape == verdicts.onsets.shape == (len(verdicts.ends), 2)
    assert ((verdicts.onsets >= 0) == verdicts.fired).all()


@pytest.mark.parametrize("value", [0, 16384, 32736])
def test_flat_and_saturated_streams_say_nothing(detector, value):
    assert detect(detector, constant(value)) == []


def test_an_unplugged_finger_leaves_the_other_alone(detector):
    pinch = closing(9)
    with_both = detect(detector, pinch)
    data = pinch.data.copy()
    dead = pinch.first.finger.other
    data[:, dead] = 32736
    alone = detect(detector, replace(pinch, data=data))
    assert [c for c in with_both if c.finger is not dead] == alone


def test_a_contact_during_the_steady_state_does_not_crash(detector):
    pinch = closing(10)
    late = pinch.first.sample - pinch.first_sample - 50
    detect(detector, replace(pinch, data=pinch.data[late:]))


def test_samples_that_are_not_finite_are_a_gap(detector):
    pinch = closing(11)
    data = pinch.data.astype(np.float32)
    data[300, 0] = np.nan
    data[301, 1] = np.inf
    detector.start(LAYOUT)
    verdicts = detector.judge(Block(data, 0))
    inside = (verdicts.ends >= 300) & (verdicts.ends < 302 + STEADY)
    assert not inside.any()
    detector.start(LAYOUT)
    after = detector.judge(Block(data[302:], 302))
    resumed = verdicts.ends >= 302
    assert np.array_equal(verdicts.ends[resumed], after.ends)
    assert np.array_equal(verdicts.fired[resumed], after.fired)


def test_short_and_empty_streams_say_nothing(detector):
    pinch = closing(12)
    for n in (0, 1, STEADY, STEADY + 14):
        assert detect(detector, replace(pinch, data=pinch.data[:n])) == []


def test_one_piezo_channel_is_enough(detector):
    pinch = closing(13)
    finger = pinch.first.finger
    single = replace(LAYOUT, channels=(LAYOUT.channels[finger],))
    alone = detect(detector, Pinch(pinch.data[:, [finger]], single, first_sample=10))
    both = detect(detector, replace(pinch, first_sample=10))
    assert alone == [c for c in both if c.finger is finger]


def test_no_piezo_channel_is_refused(detector):
    strips = Layout(LAYOUT.channels[14:], LAYOUT.rate, LAYOUT.smoothing_alpha)
    with pytest.raises(InputError, match="no piezo channel"):
        detector.start(strips)


def test_raw_data_are_smoothed_as_the_device_would(detector):
    raw = replace(LAYOUT, smoothing_alpha=1.0)
    pinch = closing(14)
    # Undoing the recursion y += (x - y) / 2 gives what the device had smoothed.
    y = pinch.data.astype(np.float64)
    x = y.copy()
    x[1:] = 2 * y[1:] - y[:-1]
    unsmoothed = Pinch(x, raw, first_sample=pinch.first_sample)
    assert detect(detector, unsmoothed) == detect(detector, pinch)


def test_fingers_in_one_window_come_in_the_order_of_their_onsets(detector):
    together = 0
    for pinch in closings(10, seed=5).pinches:
        data = pinch.data.copy()
        index = np.roll(data[:, pinch.first.finger], 2)
        data[:, Finger.THUMB] = data[:, pinch.first.finger]
        data[:, Finger.INDEX] = index
        contacts = detect(detector, replace(pinch, data=data))
        if len({c.decided for c in contacts}) == 1 and len(contacts) == 2:
            together += contacts[0].sample < contacts[1].sample
            assert contacts[0].sample <= contacts[1].sample
    assert together
