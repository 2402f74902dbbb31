"""Contacts of a closing, live and in recorded pinches, in blocks of any size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from clicks import LAYOUT, listen, make_pinch
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.contact import (
    ContactListener,
    ThresholdDetector,
    detect,
    first_contact,
    judge_pinch,
)
from firstcontact.contact._confirmation import KEPT
from firstcontact.core import Block, Contact, Finger, Pinch
from firstcontact.signal import samples_in


@given(st.lists(st.integers(0, 1480), max_size=40))
def test_events_do_not_depend_on_the_sizes_of_blocks(edges: list[int]) -> None:
    pinch = make_pinch(3, click=True)
    assert listen(pinch, edges) == listen(pinch, [])


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


def test_pinch_without_contact_is_judged_to_its_end(clicked: Pinch) -> None:
    detector = ThresholdDetector(1e6)
    judged = judge_pinch(detector, clicked, 0)
    assert judged.first is None
    assert judged.windows.ends[-1] >= clicked.first_sample + len(clicked.data) - 15


def test_first_contact_is_that_of_all_contacts(clicked: Pinch) -> None:
    detector = ThresholdDetector(8.0)
    for pinch in (clicked, replace(clicked, data=clicked.data[:300])):
        assert first_contact(detector, pinch) == next(iter(detect(detector, pinch)), None)


def test_listener_ends_with_both_contacts_and_reports_when_it_is_due(clicked: Pinch) -> None:
    listener = ContactListener(ThresholdDetector(8.0), LAYOUT)
    start, due = 0, listener.due
    while not listener.ended and start + due <= len(clicked.data):
        quiet = clicked.data[start : start + due - 1]
        assert listener.update(Block(quiet, clicked.first_sample + start)) == []
        start += due
        listener.update(Block(clicked.data[start - 1 : start], clicked.first_sample + start - 1))
        due = listener.due
    assert listener.ended


def test_memory_of_a_long_closing_is_bounded() -> None:
    listener = ContactListener(ThresholdDetector(1e5), LAYOUT)
    rng = np.random.default_rng(1)
    for start in range(0, 40_000, 50):
        noise = rng.integers(-99, 99, (50, 16)).astype(np.int16)
        listener.update(Block(noise, start))
    assert sum(map(len, listener._latch._past)) <= samples_in(KEPT, LAYOUT.rate) + 100


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
    (contact,) = listen(pinch, edges)
    assert isinstance(contact, Contact)
    assert contact.finger is Finger.INDEX
    assert abs(contact.sample - 750) <= 8
    assert judge_pinch(ThresholdDetector(8.0), pinch, 0).first == contact
    judged = judge_pinch(ThresholdDetector(8.0), pinch, len(data))
    assert judged.first == contact
    alone = ThresholdDetector(8.0)
    alone.start(LAYOUT)
    fixed = alone.judge(Block(pinch.data))
    for name in ("ends", "fired", "onsets"):
        assert np.array_equal(getattr(judged.fixed_windows, name), getattr(fixed, name))
    assert not fixed.fired.any()
    assert judged.windows.fired.any()


@pytest.mark.parametrize("interruption", ["samples that are not finite", "gap", "epoch"])
def test_steady_state_after_an_interruption_does_not_depend_on_blocks(interruption: str) -> None:
    """The motor starts anew after the interruption, and louder than before."""
    rng = np.random.default_rng(8)
    data = np.zeros((3000, LAYOUT.width))
    sigma = np.repeat([40.0, 800.0, 160.0], [600, 500, 1900])[:, None]
    data[:, :2] = 16384 + sigma * rng.standard_normal((3000, 2))
    gap, epoch = 37 * (interruption == "gap"), int(interruption == "epoch")
    if interruption.startswith("samples"):
        data[600] = np.nan
    states = []
    for size in (10, 49, 247, 3000):
        detector = ThresholdDetector(100.0)
        listener = ContactListener(detector, LAYOUT)
        for first, last, lost, number in ((0, 600, 0, 0), (600, 3000, gap, epoch)):
            for start in range(first, last, size):
                piece = data[start : min(start + size, last)]
                listener.update(Block(piece, start + lost, number))
        assert detector._state is not None
        states.append(detector._state.sigma)
    assert all(np.array_equal(state, states[0]) for state in states[1:])
