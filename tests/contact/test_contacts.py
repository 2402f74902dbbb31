"""Contacts live and in recorded pinches: closings with gaps, and confirmation."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from clicks import CLICK, LAYOUT, listen, make_pinch
from hand_stream import CALIBRATION, hand_stream
from hypothesis import given, settings
from hypothesis import strategies as st

from firstcontact.chain import EventKind
from firstcontact.chain.image import CONFIRMED
from firstcontact.contact import ThresholdDetector, detect
from firstcontact.contact.closing import ClosingBegan, ClosingEnded, Closings, ClosingSamples
from firstcontact.contact.contacts import contact_chain, judge_pinch, judge_windows
from firstcontact.core import Block, Contact, Pinch
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


DATA, CLOSINGS = hand_stream(4)
#: Numbers of samples in a block, used in turn.
SIZES = st.lists(st.integers(1, 5000), min_size=1, max_size=6)


def stages(streams: list[tuple[int, int, int]], sizes: list[int]) -> list[object]:
    """Return the closings of parts of DATA, and the contacts in them.

    A part is its first sample, the sample after its last one, and its epoch.
    """
    closings = Closings(LAYOUT, ThresholdDetector(10.0), CALIBRATION)
    size, found = itertools.cycle(sizes), []
    for place, end, epoch in streams:
        while place < end:
            stop = min(end, place + next(size))
            for stage in closings.update(Block(DATA[place:stop], place, epoch)):
                is_edge = isinstance(stage, (ClosingBegan, ClosingEnded))
                found += [stage] if is_edge else stage.contacts
            place = stop
    return found


@settings(max_examples=25)
@given(
    edges=st.lists(st.integers(0, len(DATA)), min_size=2, max_size=8, unique=True),
    epochs=st.lists(st.integers(0, 1), min_size=4, max_size=4),
    sizes=SIZES,
)
def test_blocks_do_not_matter(edges: list[int], epochs: list[int], sizes: list[int]) -> None:
    """Neither after lost samples, nor in a new epoch, nor for a stream that begins later than 0."""
    pairs = zip(*[iter(sorted(edges))] * 2, strict=False)
    streams = [(a, b, sum(epochs[: k + 1])) for k, (a, b) in enumerate(pairs)]
    assert stages(streams, sizes) == stages(streams, [5])


def test_one_block_that_begins_an_epoch_has_all_its_closings() -> None:
    found = stages([(0, 500, 0), (0, len(DATA), 1)], [10**6])
    contacts = [s.sample for s in found if isinstance(s, Contact)]
    for closing in CLOSINGS:
        assert any(abs(sample - closing.first) < 5 for sample in contacts)
    ends = [s for s in found if isinstance(s, ClosingEnded)]
    assert {(end.epoch, end.is_complete) for end in ends} == {(1, True)}


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
