"""Contacts of a closing, live and in recorded pinches, in blocks of any size."""

import numpy as np
import pytest
from clicks import LAYOUT, listen
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.chain import EventKind
from firstcontact.contact import ThresholdDetector, detect
from firstcontact.contact.contacts import judge_pinch, judge_windows
from firstcontact.core import Block, Pinch
from firstcontact.signal import samples_in


@pytest.mark.parametrize("until", [0, 100, 700, 10_000])
def test_judging_ends_when_the_first_contact_stands(clicked: Pinch, until: int) -> None:
    detector = ThresholdDetector(8.0)
    every = judge_pinch(detector, clicked, clicked.first_sample + len(clicked.data)).windows
    judged = judge_pinch(detector, clicked, clicked.first_sample + until)
    assert judged.first is not None
    assert judged.first == detect(detector, clicked)[0]
    n = len(judged.windows.ends)
    for name in ("ends", "fired", "onsets"):
        assert np.array_equal(getattr(judged.windows, name), getattr(every, name)[:n])
    deadline = clicked.first_sample + min(until, len(clicked.data)) - 1
    least = max(deadline - samples_in(detector.step, LAYOUT.rate), judged.first.decided - 1)
    assert judged.windows.ends[-1] > least
    assert (n < len(every.ends)) == (until < len(clicked.data))


@given(st.lists(st.integers(0, 900), max_size=20))
def test_contact_after_a_loud_start_of_the_motor_is_detected(edges: list[int]) -> None:
    """The noise level falls to a tenth after the first steady state was measured."""
    rng = np.random.default_rng(4)
    data = np.zeros((900, LAYOUT.width))
    data[:, :2] = 16384 + rng.normal(0, 40, (900, 2))
    data[:250, :2] += rng.normal(0, 400, (250, 2))
    age = np.arange(150)
    data[750:, 0] += 900 * np.sin(2 * np.pi * 90 * age / LAYOUT.rate) * np.exp(-age / 60)
    pinch = Pinch(data.astype(np.int16), LAYOUT)
    assert detect(ThresholdDetector(8.0), pinch, confirm=False) == []
    (event,) = listen(pinch, edges)
    assert (event.kind, event.channel) == (EventKind.CONTACT_FOUND, 0)
    assert abs(event.sample - 750) <= 8
    contact = judge_pinch(ThresholdDetector(8.0), pinch, 0).first
    assert (contact.sample, contact.decided) == (event.sample, event.known)
    judged = judge_pinch(ThresholdDetector(8.0), pinch, len(data))
    assert judged.first == contact
    fixed = judge_windows(ThresholdDetector(8.0), LAYOUT, Block(pinch.data))
    for name in ("ends", "fired", "onsets"):
        assert np.array_equal(getattr(judged.fixed_windows, name), getattr(fixed, name))
    assert not fixed.fired.any()
    assert judged.windows.fired.any()
