"""Contacts cut from a stream equal those cut from the complete pinch, for any block sizes."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Block, Contact, Dataset, Finger, Layout, Pinch, fingertip_layout
from firstcontact.models import Touches, TouchStream, cut_touches, moments

LAYOUT = fingertip_layout()
#: As long as 0.2 s, and where the contact is in it.
LENGTH, AT = 1000, 500


def noise(layout: Layout = LAYOUT, seed: int = 0) -> Pinch:
    """Return a pinch of noise, without labels or contacts."""
    data = np.random.default_rng(seed).integers(-500, 500, (LENGTH, layout.width))
    return Pinch(data.astype(np.int16), layout, first_sample=7000)


def stream_touches(pinch: Pinch, contact: Contact, edges: list[int]) -> list[Touches]:
    """Return the touches of a stream for a pinch cut at these positions."""
    stream = TouchStream(pinch.layout)
    collected = []
    places = [0, *sorted(set(edges)), len(pinch.data)]
    text = False
    for a, b in itertools.pairwise(places):
        block = Block(pinch.data[a:b], pinch.first_sample + a)
        new = contact if not text and contact.decided < block.end else None
        text = text or new is not None
        touches = stream.update(block, new)
        if touches is not None:
            collected.append(touches)
    return collected


def make_contact(decided: int = AT + 11, finger: Finger | None = Finger.THUMB) -> Contact:
    return Contact(finger, 7000 + AT, 7000 + decided)


def test_moments_are_whole_milliseconds_from_2_to_15() -> None:
    assert moments(1000.0) == tuple(range(2, 16))
    assert moments(LAYOUT.rate)[0] == 10
    assert moments(LAYOUT.rate)[-1] == 74


@given(edges=st.lists(st.integers(1, LENGTH - 1), max_size=40), decided=st.integers(AT, AT + 100))
def test_a_stream_gives_what_is_cut_from_the_pinch(edges: list[int], decided: int) -> None:
    pinch, contact = noise(), make_contact(decided)
    contacts = stream_touches(pinch, contact, edges)
    assert [int(n) for t in contacts for n in t.valid] == list(moments(LAYOUT.rate))
    offline, _ = cut_touches(Dataset((pinch,)), [contact])
    for touches in contacts:
        assert set(touches.fingers) == {int(offline.fingers[0])}
        for signal, n in zip(touches.signals, touches.valid, strict=True):
            end = touches.lead + n
            assert np.array_equal(signal[:end], offline.until(int(n)).signals[0, :end])


def test_a_raw_device_is_smoothed_as_offline() -> None:
    from dataclasses import replace

    raw = replace(
        LAYOUT,
        channels=tuple(
            replace(c, smoothing_alpha=1.0) if c in LAYOUT.vibration else c for c in LAYOUT.channels
        ),
    )
    pinch, contact = noise(raw), make_contact()
    offline, _ = cut_touches(Dataset((pinch,)), [contact])
    (last,) = stream_touches(pinch, contact, [])
    end = last.lead + 74
    assert np.array_equal(last.signals[-1][:end], offline.signals[0, :end])


def test_due_says_how_many_samples_the_next_moment_takes() -> None:
    pinch, stream = noise(), TouchStream(LAYOUT)
    assert stream.due is None
    assert stream.update(Block(pinch.data[: AT + 5], 7000), make_contact(AT)) is None
    assert stream.due == 5
    touches = stream.update(Block(pinch.data[AT + 5 : AT + 10], 7000 + AT + 5))
    assert touches is not None
    assert list(touches.valid) == [10]
    assert stream.due == 5


@pytest.mark.parametrize("lost", [1, 30])
def test_nothing_is_told_across_a_gap(lost: int) -> None:
    pinch, stream = noise(), TouchStream(LAYOUT)
    stream.update(Block(pinch.data[: AT + 12], 7000), make_contact())
    assert stream.update(Block(pinch.data[AT + 12 + lost :], 7012 + AT + lost)) is None
    assert stream.ended
    assert stream.refused == "samples after the contact were lost"


def test_a_dead_piezo_and_too_little_before_are_refused() -> None:
    flat = noise()
    data = np.array(flat.data)
    data[:, LAYOUT.columns(LAYOUT.vibration[0].kind, Finger.THUMB)] = 3
    for samples in (data, flat.data[AT - 20 :]):
        stream = TouchStream(LAYOUT)
        first = 7000 + LENGTH - len(samples)
        assert stream.update(Block(samples, first), make_contact()) is None
        assert "too little signal" in stream.refused
