"""Windows after a contact: complete or refused, equal offline and live."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firstcontact.core import Block, Contact, Dataset, Finger, Pinch, fingertip_layout
from firstcontact.signal import WindowStream, contact_windows, samples_in

LAYOUT = fingertip_layout()
FIRST = 5000
DURATION = 0.015


def pinch(n: int = 600, seed: int = 0, layout=LAYOUT) -> Pinch:
    data = np.random.default_rng(seed).normal(16384, 60, (n, 16)).astype(np.int16)
    return Pinch(data, layout, first_sample=FIRST)


def contact(position: int, finger: Finger = Finger.INDEX) -> Contact:
    return Contact(finger, FIRST + position, FIRST + position + 10)


def test_samples_in_rounds():
    assert samples_in(0.015, 4936.0) == 74
    assert samples_in(0.002, 4936.0) == 10


def test_windows_start_at_the_contact_with_the_quiet_removed():
    data = np.full((600, 16), 16384.0, dtype=np.float32)
    data[:, 0] += 1000.0
    # Slow against the filter, so that it leaves the ramp as it is.
    data[300:, 0] += np.arange(300.0) * 10
    p = Pinch(data, LAYOUT, first_sample=FIRST)
    X, is_valid = contact_windows(Dataset((p,)), [contact(310)], DURATION)
    volts = (np.arange(74) + 10) * 10 * LAYOUT.channels[0].scale
    assert is_valid.tolist() == [True]
    assert X.shape == (1, 74, 1)
    assert X.dtype == np.float32
    np.testing.assert_allclose(X[0, :, 0], volts, rtol=0.05)


def test_incomplete_windows_are_dropped():
    last_start = 600 - 74 - 2  # the filter looks ahead two samples
    cases = {
        "none": (None, False),
        "last whole": (contact(last_start), True),
        "past the end": (contact(last_start + 1), False),
        "no quiet before": (contact(15), False),
        "just enough quiet": (contact(20), True),
        "before the pinch": (contact(-30), False),
    }
    p = pinch()
    X, is_valid = contact_windows(
        Dataset((p,) * len(cases)), [c for c, _ in cases.values()], DURATION
    )
    assert is_valid.tolist() == [expected for _, expected in cases.values()]
    assert len(X) == is_valid.sum()


def test_flat_and_not_finite_windows_are_dropped():
    flat = Pinch(np.full((600, 16), 16384, dtype=np.int16), LAYOUT, first_sample=FIRST)
    holed = pinch().data.astype(np.float32)
    holed[320] = np.nan
    X, is_valid = contact_windows(
        Dataset((flat, Pinch(holed, LAYOUT, first_sample=FIRST))), [contact(300)] * 2, DURATION
    )
    assert not is_valid.any()
    assert X.shape == (0, 74, 1)


def test_smoothed_data_are_not_smoothed_again():
    raw_layout = replace(LAYOUT, smoothing_alpha=1.0)
    # The same numbers, once said to be raw: only those lose noise.
    as_is, _ = contact_windows(Dataset((pinch(),)), [contact(300)], DURATION)
    smoothed, _ = contact_windows(Dataset((pinch(layout=raw_layout),)), [contact(300)], DURATION)
    assert smoothed.std() < 0.9 * as_is.std()


@given(
    cuts=st.lists(st.integers(0, 600), max_size=15),
    position=st.integers(20, 500),
    finger=st.sampled_from(Finger),
)
@settings(max_examples=40, deadline=None)
def test_live_windows_equal_offline_windows(cuts, position, finger):
    p = pinch()
    contact_mark = contact(position, finger)
    offline, _ = contact_windows(Dataset((p,)), [contact_mark], DURATION)
    stream = WindowStream(LAYOUT, [DURATION])
    edges = [0, *sorted(cuts), 600]
    windows = []
    open_ = True
    for a, b in itertools.pairwise(edges):
        news = [contact_mark] if open_ and FIRST + b > contact_mark.decided else []
        open_ = open_ and not news
        new_windows = stream.update(Block(p.data[a:b], FIRST + a), news)
        windows += new_windows
        for w in new_windows:
            assert w.complete < FIRST + b
    assert len(windows) == 1
    assert np.array_equal(windows[0].samples, offline[0])
    assert windows[0].complete == FIRST + position + 74 - 1 + 2


@pytest.mark.parametrize("change", [{"first_sample": FIRST + 341}, {"epoch": 1}])
def test_no_window_across_a_gap(change):
    p = pinch()
    stream = WindowStream(LAYOUT, [DURATION])
    assert stream.update(Block(p.data[:340], FIRST), [contact(300)]) == []
    next_block = Block(p.data[340:], FIRST + 340)
    assert stream.update(replace(next_block, **change)) == []
    assert stream.refused == 1


def test_long_stream_keeps_windows_of_all_contacts():
    p = pinch(20_000)
    stream = WindowStream(LAYOUT, [DURATION])
    windows = []
    for a in range(0, 20_000, 15):
        news = [contact(a)] if a % 3000 == 1500 else []
        windows += stream.update(Block(p.data[a : a + 15], FIRST + a), news)
    offline, is_valid = contact_windows(
        Dataset((p,) * len(windows)), [w.contact for w in windows], DURATION
    )
    assert is_valid.all()
    assert len(windows) == 7
    assert np.array_equal(np.stack([w.samples for w in windows]), offline)


def test_contact_reported_too_late_is_refused():
    p = pinch(20_000)
    stream = WindowStream(LAYOUT, [DURATION])
    for a in range(0, 20_000, 100):
        stream.update(Block(p.data[a : a + 100], FIRST + a))
    assert stream.update(Block(p.data[:0], FIRST + 20_000), [contact(30)]) == []
    assert stream.refused == 1
