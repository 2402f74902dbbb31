"""Reduced traces keep peaks and gaps, for any block size."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from page_feed import LAYOUT, RATE

from firstcontact.core import Block, Contact, Finger
from firstcontact.streaming.page.traces import AFTER, BEFORE, Closeup, Columns

VOLT = LAYOUT.channels[0].scale
ZERO = LAYOUT.channels[0].offset


def block(first: int, n: int, epoch: int = 0, thumb: int = 7) -> Block:
    """Return samples whose index channel counts them, within the range of int16."""
    raw = np.full((n, len(LAYOUT.channels)), thumb, np.int16)
    raw[:, 0] = (first + np.arange(n)) % 30_000
    return Block(raw, first, epoch)


def volts(raw: float) -> float:
    return (raw - ZERO) * VOLT


@settings(max_examples=20)  # each compares thousands of columns
@given(st.lists(st.integers(1, 300), min_size=1, max_size=30), st.integers(0, 2**40))
def test_every_sample_is_in_its_column(sizes: list[int], start: int) -> None:
    columns = Columns(LAYOUT)
    at = start
    for n in sizes:
        columns.add(block(at, n))
        at += n
    first, got = columns.since(0)
    for k in range(len(got)):
        positions = start + (first + k) * columns.samples + np.arange(columns.samples)
        raw = positions % 30_000
        np.testing.assert_allclose(got[k, 0], [volts(raw.min()), volts(raw.max())], rtol=1e-5)
        np.testing.assert_allclose(got[k, 1], volts(7), rtol=1e-5)
    assert first + len(got) == (sum(sizes) - 1) // columns.samples


@given(st.integers(0, 200), st.integers(1, 40_000), st.integers(1, 500))
def test_a_gap_is_empty(lead: int, gap: int, tail: int) -> None:
    columns = Columns(LAYOUT)
    columns.add(block(0, lead + 1))
    columns.add(block(lead + 1 + gap, tail))
    first, got = columns.since(0)
    for k, column in enumerate(got):
        begin = (first + k) * columns.samples
        positions = np.arange(begin, begin + columns.samples)
        arrival = (positions <= lead) | (positions > lead + gap)
        assert np.isnan(column).all() == (not arrival.any())


def test_epochs_are_not_joined() -> None:
    columns = Columns(LAYOUT)
    columns.add(block(5000, 800))
    old = columns.place(5400, 0)
    columns.add(block(0, 800, epoch=1))
    assert old == 400 / columns.samples
    assert columns.place(5400, 0) == old
    assert columns.place(5400, 9) is None
    assert columns.place(0, 1) == 101.0
    _, got = columns.since(99)
    assert np.isnan(got[1]).all()
    assert not np.isnan(got[0]).any()
    assert not np.isnan(got[2]).any()


@given(st.integers(1, 400), st.integers(0, 200))
def test_the_closeup_has_every_sample_once(n: int, late: int) -> None:
    closeup = Closeup(LAYOUT)
    contact = Contact(Finger.INDEX, 1000, 1000 + late)
    predictions = False
    for first in range(0, 2000, n):
        closeup.add(block(first, n))
        if not predictions and first + n > contact.decided:
            closeup.begin(contact, 0)
            predictions = True
    tree = closeup.tree()
    samples = np.arange(1000 - round(BEFORE * RATE), 1000 + round(AFTER * RATE) + 1)
    np.testing.assert_allclose(tree["traces"][0], volts(samples), atol=6e-5)
    np.testing.assert_allclose(tree["ms"], (samples - 1000) / RATE * 1e3, atol=6e-4)
