"""Windows after a contact: whole or refused, the same offline and live."""

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
    X, kept = contact_windows(Dataset((p,)), [contact(310)], DURATION)
    volts = (np.arange(74) + 10) * 10 * LAYOUT.channels[0].scale
    assert kept.tolist() == [True]
    assert X.shape == (1, 74, 1)
    assert X.dtype == np.float32
    np.testing.assert_allclose(X[0, :, 0], volts, rtol=0.05)


def test_what_is_not_whole_is_not_kept():
    last = 600 - 74 - 2  # the filter looks ahead two samples
    cases = {
        "none": (None, False),
        "last whole": (contact(last), True),
        "past the end": (contact(last + 1), False),
        "no quiet before": (contact(15), False),
        "just enough quiet": (contact(20), True),
        "before the pinch": (contact(-30), False),
    }
    p = pinch()
    X, kept = contact_windows(Dataset((p,) * len(cases)), [c for c, _ in cases.values()], DURATION)
    assert kept.tolist() == [whole for _, whole in cases.values()]
    assert len(X) == kept.sum()


def test_flat_and_not_finite_windows_are_not_kept():
    flat = Pinch(np.full((600, 16), 16384, dtype=np.int16), LAYOUT, first_sample=FIRST)
    holed = pinch().data.astype(np.float32)
    holed[320] = np.nan
    X, kept = contact_windows(
        Dataset((flat, Pinch(holed, LAYOUT, first_sample=FIRST))), [contact(300)] * 2, DURATION
    )
    assert not kept.any()
    assert X.shape == (0, 74, 1)


def test_what_the_device_smoothed_is_not_smoothed_twice():
    raw_layout = replace(LAYOUT, smoothing_alpha=1.0)
    # The same numbers, once said to be raw: only those lose noise.
    as_is, _ = contact_windows(Dataset((pinch(),)), [contact(300)], DURATION)
    smoothed, _ = contact_windows(Dataset((pinch(layout=raw_layout),)), [contact(300)], DURATION)
    assert smoothed.std() < 0.9 * as_is.std()


def test_one_contact_a_pinch():
    with pytest.raises(ValueError, match="0 contacts for 1 pinches"):
        contact_windows(Dataset((pinch(),)), [], DURATION)


@given(
    cuts=st.lists(st.integers(0, 600), max_size=15),
    position=st.integers(20, 500),
    finger=st.sampled_from(Finger),
)
@settings(max_examples=40, deadline=None)
def test_live_is_offline(cuts, position, finger):
    p = pinch()
    told = contact(position, finger)
    offline, _ = contact_windows(Dataset((p,)), [told], DURATION)
    stream = WindowStream(LAYOUT, [DURATION])
    edges = [0, *sorted(cuts), 600]
    windows = []
    open_ = True
    for a, b in itertools.pairwise(edges):
        news = [told] if open_ and FIRST + b > told.decided else []
        open_ = open_ and not news
        done = stream.update(Block(p.data[a:b], FIRST + a), news)
        windows += done
        for w in done:
            assert w.complete < FIRST + b
    assert len(windows) == 1
    assert np.array_equal(windows[0].samples, offline[0])
    assert windows[0].complete == FIRST + position + 74 - 1 + 2


@pytest.mark.parametrize("change", [{"first_sample": FIRST + 341}, {"epoch": 1}])
def test_no_window_across_a_gap(change):
    p = pinch()
    stream = WindowStream(LAYOUT, [DURATION])
    assert stream.update(Block(p.data[:340], FIRST), [contact(300)]) == []
    after = Block(p.data[340:], FIRST + 340)
    assert stream.update(replace(after, **change)) == []
    assert stream.refused == 1


def test_a_long_stream_is_forgotten_but_contacts_are_served():
    p = pinch(20_000)
    stream = WindowStream(LAYOUT, [DURATION])
    done = []
    for a in range(0, 20_000, 15):
        news = [contact(a)] if a % 3000 == 1500 else []
        done += stream.update(Block(p.data[a : a + 15], FIRST + a), news)
    offline, kept = contact_windows(Dataset((p,) * len(done)), [w.contact for w in done], DURATION)
    assert kept.all()
    assert len(done) == 7
    assert np.array_equal(np.stack([w.samples for w in done]), offline)


def test_a_contact_told_too_late_is_refused():
    p = pinch(20_000)
    stream = WindowStream(LAYOUT, [DURATION])
    for a in range(0, 20_000, 100):
        stream.update(Block(p.data[a : a + 100], FIRST + a))
    assert stream.update(Block(p.data[:0], FIRST + 20_000), [contact(30)]) == []
    assert stream.refused == 1
