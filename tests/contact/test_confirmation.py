"""Confirmation of first contacts: clicks are withdrawn, and the true contact follows."""

from dataclasses import replace

import numpy as np
import pytest
from clicks import CLICK, LAYOUT, listen, make_pinch

from firstcontact.chain import EventKind
from firstcontact.chain.image import CONFIRMED
from firstcontact.contact import ThresholdDetector, detect
from firstcontact.contact.closing import ClosingBegan, ClosingEnded, Closings, ClosingSamples
from firstcontact.contact.contacts import contact_chain
from firstcontact.core import Block, Pinch
from firstcontact.signal import samples_in

AGE = samples_in(CONFIRMED, LAYOUT.rate)


def test_click_is_withdrawn_and_the_true_contact_follows(clicked: Pinch) -> None:
    false, withdrawal, true, *_ = listen(clicked, [])
    kinds = [event.kind for event in (false, withdrawal, true)]
    found, withdrawn = EventKind.CONTACT_FOUND, EventKind.CONTACT_WITHDRAWN
    assert kinds == [found, withdrawn, found]
    assert abs(false.sample - clicked.first_sample - CLICK) <= 15
    assert (withdrawal.channel, withdrawal.sample) == (false.channel, false.sample)
    assert withdrawal.known == max(false.sample + AGE - 1, false.known)
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
    ("frequency", "peak", "stands"),
    [(90.0, 10.0, True), (90.0, 3.0, False), (900.0, 15.0, False), (900.0, 60.0, True)],
    ids=["push", "swell", "click", "loud ringing"],
)
def test_push_is_slow_and_clear_of_the_motor(frequency: float, peak: float, stands: bool) -> None:
    data = np.zeros((700, LAYOUT.width))
    data[:, :2] = np.random.default_rng(2).uniform(-1.7, 1.7, (700, 2))
    age = np.arange(100)
    data[600:, 0] += peak * np.sin(2 * np.pi * frequency * age / LAYOUT.rate)
    chain = contact_chain(ThresholdDetector(2.5), LAYOUT)
    kinds = [event.kind for event in chain.take(Block(16384 + 40 * data))[1:]]
    assert kinds[0] == EventKind.CONTACT_FOUND
    assert (EventKind.CONTACT_WITHDRAWN in kinds) != stands
