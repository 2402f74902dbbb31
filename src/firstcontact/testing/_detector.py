"""Check of a contact detector, such as that of a plug-in."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np

from firstcontact.chain import EventKind
from firstcontact.contact import DETECTORS, Detector, load_detector, save_detector
from firstcontact.contact import detect as detect_and_confirm
from firstcontact.contact.contacts import contact_chain, judge_windows
from firstcontact.core import Block, Contact, Finger, Layout, Pinch
from firstcontact.signal import samples_in
from firstcontact.testing.synthetic import LAYOUT, SAMPLES, closing, closings, refused

#: Detection that confirms and withdraws no contacts, because detectors do not do that.
detect = partial(detect_and_confirm, confirm=False)


def check_detector(detector_class: type[Detector], seed: int = 0) -> None:
    """Assert that a contact detector behaves as its base class requires, on synthetic pinches.

    Parameters
    ----------
    detector_class
        Class of the detector. Saving and loading are checked only if the class is registered.
    seed
        Random seed for the sizes of the blocks in which the detector gets a signal.

    Raises
    ------
    AssertionError
        A check failed (the message names it), or there was nothing to check.
    """
    assert detector_class.name, "the detector has no name"
    assert detector_class.title, "the detector has no title"
    assert 0 < detector_class.step <= detector_class.duration, (
        "the detector's step is not a part of its window"
    )
    untrained = detector_class()
    if detector_class.learns:
        refused("", lambda: detector_class().fit(closings(0)))
    detector = untrained.fit(closings(40, seed=1))
    contacts = [detect(detector, pinch) for pinch in closings(20, seed=3).pinches]
    assert any(contacts), "the detector detects no contact: there is nothing to check"
    _check_contacts(detector)
    _check_streams(detector, seed)
    _check_gaps(detector)
    _check_channels(detector)
    _check_saved(detector_class, detector)


def _feed(detector: Detector, pinch: Pinch, edges: Iterable[int]) -> list[Contact]:
    chain = contact_chain(detector, pinch.layout, keeps_first_state=True)
    return [
        Contact(pinch.layout.vibration_fingers[event.channel], event.sample, event.known)
        for a, b in pairwise(edges)
        for event in chain.take(Block(pinch.data[a:b], pinch.first_sample + a))
        if event.kind == EventKind.CONTACT_FOUND
    ]


def _check_contacts(detector: Detector) -> None:
    right = 0
    pinches = closings(20, seed=3).pinches
    for pinch in pinches:
        contacts = detect(detector, pinch)
        assert pinch.first is not None
        right += bool(contacts) and abs(contacts[0].sample - pinch.first.sample) <= 15
        fingers = [c.finger for c in contacts]
        bare = replace(pinch, truth=())
        assert len(fingers) == len(set(fingers)), "a finger touches twice in one closing"
        assert detect(detector, pinch) == contacts, (
            "the detector keeps something of an earlier closing"
        )
        for contact in contacts:
            age = (contact.decided - contact.sample) / LAYOUT.rate
            assert 0 <= age <= detector.duration, "the onset is not in the deciding window"
            cut = contact.decided + 1 - pinch.first_sample
            detected = detect(detector, replace(bare, data=bare.data[:cut]))
            assert contact in detected, "a decision depends on a later sample"
            detected = detect(detector, replace(bare, data=bare.data[: cut - 1]))
            assert contact not in detected, "the contact's decision sample is too late"
    assert right >= len(pinches) // 5, "too few contacts are detected at the right sample"


def _check_streams(detector: Detector, seed: int) -> None:
    rng = np.random.default_rng(seed)
    for number in range(4):
        pinch = closing(100 * seed + number)
        expected = detect(detector, pinch)
        for cuts in (rng.integers(0, SAMPLES, 20), np.arange(SAMPLES)):
            contacts_ = _feed(detector, pinch, [0, *np.sort(cuts).tolist(), SAMPLES])
            assert contacts_ == expected, "the block sizes change the contacts"
    pinch, far = closing(6), 2**40
    moved = detect(detector, replace(pinch, first_sample=far, truth=()))
    shift = far - pinch.first_sample
    for a, b in zip(detect(detector, pinch), moved, strict=True):
        assert (b.sample - a.sample, b.decided - a.decided) == (shift, shift), (
            "the contacts depend on the sample numbers"
        )
    decisions = judge_windows(detector, LAYOUT, Block(closing(8).data, 500))
    assert decisions.fired.shape == decisions.onsets.shape == (len(decisions.ends), 2), (
        "the decisions have wrong shapes"
    )
    assert ((decisions.onsets >= 0) == decisions.fired).all(), (
        "onsets do not match the windows that fired"
    )
    step = samples_in(detector.step, LAYOUT.rate)
    assert set(np.diff(decisions.ends)) == {step}, "there is not one window per step"
    for n in (0, 1, step):
        short = replace(pinch, data=pinch.data[:n], truth=())
        assert detect(detector, short) == [], "the detector detects a contact in almost no samples"


def _check_gaps(detector: Detector) -> None:
    # The signal is loud after the gap and quiet before it. A window across the gap would show a
    # contact.
    quiet = closing(7, touches=False).data
    loud = ((quiet.astype(np.int32) - 16384) * 30 + 16384).clip(0, 32736).astype(np.int16)
    for later in (Block(loud, SAMPLES, epoch=1), Block(loud, 10**6, epoch=1)):
        decisions = judge_windows(detector, LAYOUT, Block(quiet, 0), later)
        is_later = decisions.ends >= SAMPLES
        first = decisions.ends[is_later].min() - samples_in(detector.duration, LAYOUT.rate) + 1
        assert first >= later.first_sample, "a window spans a gap"
    data = closing(11).data.astype(np.float32)
    data[300, 0], data[301, 1] = np.nan, np.inf
    decisions = judge_windows(detector, LAYOUT, Block(data, 0))
    window = samples_in(detector.duration, LAYOUT.rate)
    across = (decisions.ends >= 300) & (decisions.ends < 302 + window - 1)
    assert not across.any(), "a window contains a sample that is not finite"
    after_it = judge_windows(detector, LAYOUT, Block(data[302:], 302))
    resumed = decisions.ends >= 302
    assert np.array_equal(decisions.fired[resumed], after_it.fired), (
        "the detector does not start again after a gap"
    )


def _check_channels(detector: Detector) -> None:
    for value in (0, 16384, 32736):
        flat = Pinch(np.full((SAMPLES, 16), value, dtype=np.int16), LAYOUT)
        assert detect(detector, flat) == [], "the detector detects a contact in a constant stream"
    pinch = closing(13)
    finger = pinch.truth[0].finger or Finger.INDEX
    single = replace(LAYOUT, channels=(LAYOUT.channels[finger],))
    one = detect(detector, Pinch(pinch.data[:, [finger]], single, first_sample=10))
    both = detect(detector, replace(pinch, first_sample=10, truth=()))
    assert one == [c for c in both if c.finger is finger], (
        "the detector does not work with one channel"
    )
    strips = Layout(LAYOUT.channels[14:], LAYOUT.rate)
    refused("no vibration channel", lambda: contact_chain(detector, strips))
    if detector.rate is not None:
        other = replace(LAYOUT, rate=2 * detector.rate)
        refused("", lambda: contact_chain(detector, other))


def _check_saved(detector_class: type[Detector], detector: Detector) -> None:
    if DETECTORS.get(detector_class.name) is not detector_class:
        return
    if detector_class.learns:
        with tempfile.TemporaryDirectory() as folder:
            refused("", partial(save_detector, detector_class(), Path(folder)))
    with tempfile.TemporaryDirectory() as folder:
        loaded = load_detector(save_detector(detector, Path(folder), {"pinches": 40}))
    assert type(loaded) is detector_class, "the detector's class changes by saving and loading"
    assert loaded.rate == detector.rate, "the detector's rate changes by saving and loading"
    for pinch in closings(8, seed=7).pinches:
        assert detect(loaded, pinch) == detect(detector, pinch), (
            "the detector's contacts change by saving and loading"
        )
