"""Confirmation of first contacts: clicks are withdrawn, and the true contact follows."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.contact import (
    ClosingBegan,
    ClosingEnded,
    Closings,
    ClosingSamples,
    ContactListener,
    ThresholdDetector,
    Withdrawal,
    detect,
    first_contact,
    judge_pinch,
)
from firstcontact.contact._confirmation import CONFIRMED, KEPT, ConfirmingLatch, is_push
from firstcontact.contact._detector import WindowDecisions
from firstcontact.core import Block, Contact, Finger, Pinch, fingertip_layout
from firstcontact.signal import samples_in
from firstcontact.twin import BLOCKS, PAPER_RIG, draw_pinch, draw_specimen, simulate_pinch

LAYOUT = fingertip_layout()
#: Where the click begins, and its counts.
CLICK, PEAK = 320, (30, -22, 12, -6, 3)
AGE = samples_in(CONFIRMED, LAYOUT.rate)


def make_pinch(seed: int, *, click: bool, finger: Finger = Finger.INDEX) -> Pinch:
    """Return a pinch of the twin, in which a gear clicks before the contact."""
    draw = draw_pinch(seed, PAPER_RIG, "s", draw_specimen(seed, PAPER_RIG, BLOCKS[4], 0), 0)
    pinch = simulate_pinch(draw, replace(Pinch(np.zeros((1, 16)), LAYOUT).label), 5_000)
    data = pinch.data.copy()
    if click:
        column = LAYOUT.vibration_fingers.index(finger)
        data[CLICK : CLICK + len(PEAK), column] += 32 * np.array(PEAK, np.int16)
    return replace(pinch, data=data)


@pytest.fixture(scope="module")
def clicked() -> Pinch:
    return make_pinch(3, click=True)


def listen(pinch: Pinch, edges: list[int]) -> list[Contact | Withdrawal]:
    listener = ContactListener(ThresholdDetector(8.0), pinch.layout)
    return [
        event
        for a, b in pairwise([0, *sorted(edges), len(pinch.data)])
        for event in listener.update(Block(pinch.data[a:b], pinch.first_sample + a))
    ]


def test_click_is_withdrawn_and_the_true_contact_follows(clicked: Pinch) -> None:
    false, withdrawal, true, *_ = listen(clicked, [])
    assert isinstance(false, Contact)
    assert isinstance(withdrawal, Withdrawal)
    assert isinstance(true, Contact)
    assert clicked.first is not None
    assert abs(false.sample - clicked.first_sample - CLICK) <= 15
    assert withdrawal.contact == false
    assert withdrawal.decided - false.sample == max(AGE - 1, false.decided - false.sample)
    assert abs(true.sample - clicked.first.sample) <= samples_in(0.003, LAYOUT.rate)


@given(st.lists(st.integers(0, 1480), max_size=40))
def test_events_do_not_depend_on_the_sizes_of_blocks(edges: list[int]) -> None:
    pinch = make_pinch(3, click=True)
    assert listen(pinch, edges) == listen(pinch, [])


@pytest.mark.parametrize("seed", range(6))
def test_contact_of_the_twin_stands(seed: int) -> None:
    pinch = make_pinch(seed, click=False)
    detector = ThresholdDetector(8.0)
    assert detect(detector, pinch) == detect(detector, pinch, confirm=False) != []


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


def test_sensor_of_no_finger_withdraws_nothing(clicked: Pinch) -> None:
    channel = replace(LAYOUT.channels[0], finger=None)
    layout = replace(LAYOUT, channels=(channel,))
    pinch = Pinch(clicked.data[:, :1], layout)
    detector = ThresholdDetector(8.0)
    assert detect(detector, pinch) == detect(detector, pinch, confirm=False) != []


@pytest.mark.parametrize("edges", [[], [250], [251], [100, 251, 400]])
def test_sample_that_is_not_finite_withdraws_no_later_contact(edges: list[int]) -> None:
    layout = replace(LAYOUT, smoothing_alpha=1.0)
    pinch = make_pinch(3, click=False)
    lossy = pinch.data.astype(np.float32)
    lossy[250] = np.nan
    events = listen(replace(pinch, data=lossy, layout=layout), edges)
    expected = listen(replace(pinch, layout=layout), [])
    assert [e.sample for e in events if isinstance(e, Contact)] == pytest.approx(
        [e.sample for e in expected if isinstance(e, Contact)], abs=10
    )
    assert not any(isinstance(event, Withdrawal) for event in events)


def test_contact_that_waits_at_a_gap_stands(clicked: Pinch) -> None:
    latch, start = ConfirmingLatch(LAYOUT), clicked.first_sample
    one, two = np.array([[True, False]]), np.full((1, 2), start + CLICK)
    fires = WindowDecisions(np.array([start + CLICK + 2]), one, two)
    block = Block(clicked.data[: CLICK + 4], start)
    latch.remember(block)
    (contact,) = latch.update(block, fires)
    assert latch.due is not None
    quiet = WindowDecisions(np.empty(0, np.int64), one[:0], two[:0])
    later = CLICK + 40
    block = Block(clicked.data[later:], start + later)
    latch.remember(block)
    assert latch.update(block, quiet) == []
    assert latch.is_confirmed
    assert latch.due is None
    assert latch.latched == {contact.finger}


def test_memory_of_a_long_closing_is_bounded() -> None:
    listener = ContactListener(ThresholdDetector(1e5), LAYOUT)
    rng = np.random.default_rng(1)
    for start in range(0, 40_000, 50):
        noise = rng.integers(-99, 99, (50, 16)).astype(np.int16)
        listener.update(Block(noise, start))
    assert sum(map(len, listener._latch._past)) <= samples_in(KEPT, LAYOUT.rate) + 100


def test_samples_after_a_withdrawal_belong_to_a_new_stage(clicked: Pinch) -> None:
    closings = Closings(LAYOUT, ThresholdDetector(8.0))
    stages = list(closings.update(Block(clicked.data, clicked.first_sample)))
    began, false, true, *_ = stages
    assert isinstance(began, ClosingBegan)
    assert isinstance(false, ClosingSamples)
    assert isinstance(true, ClosingSamples)
    assert not any(isinstance(stage, ClosingEnded) for stage in stages)
    assert false.withdrawn == false.contacts[0]
    assert (true.block.first_sample, true.withdrawn) == (false.block.end, None)
    assert len(true.contacts) == 2


@pytest.mark.parametrize(
    ("frequency", "peak", "expected"),
    [(90.0, 10.0, True), (90.0, 3.0, False), (900.0, 15.0, False), (900.0, 60.0, True)],
    ids=["push", "swell", "click", "loud ringing"],
)
def test_push_is_slow_and_clear_of_the_motor(frequency: float, peak: float, expected: bool) -> None:
    earlier = np.random.default_rng(2).standard_normal(80)
    later = peak * np.sin(2 * np.pi * frequency * np.arange(AGE) / LAYOUT.rate)
    signals = np.stack([earlier, -earlier]), np.stack([later, -later])
    assert is_push(*signals, LAYOUT.rate).tolist() == [expected] * 2


def test_samples_that_are_not_finite_constant_or_too_few_count_as_a_push() -> None:
    earlier = np.random.default_rng(2).standard_normal(80)
    assert is_push(np.ones(80), np.ones(AGE), LAYOUT.rate)
    assert is_push(earlier, np.array([1.0, np.nan, -1.0]), LAYOUT.rate)
    assert is_push(earlier, np.array([9.0]), 300.0)


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
