"""Confirmation of first contacts: clicks are withdrawn, and the true contact follows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from clicks import CLICK, LAYOUT, listen, make_pinch

from firstcontact.contact import (
    ClosingBegan,
    ClosingEnded,
    Closings,
    ClosingSamples,
    ThresholdDetector,
    Withdrawal,
    detect,
)
from firstcontact.contact._confirmation import CONFIRMED, ConfirmingLatch, is_push
from firstcontact.contact._detector import WindowDecisions
from firstcontact.core import Block, Contact, Pinch
from firstcontact.signal import samples_in

AGE = samples_in(CONFIRMED, LAYOUT.rate)


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


@pytest.mark.parametrize("seed", range(6))
def test_contact_of_the_twin_stands(seed: int) -> None:
    pinch = make_pinch(seed, click=False)
    detector = ThresholdDetector(8.0)
    assert detect(detector, pinch) == detect(detector, pinch, confirm=False) != []


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
