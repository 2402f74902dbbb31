"""A hand that picks things up: reproducible, without a jump, its truth the strips'."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from firstcontact.core.errors import InputError
from firstcontact.core.layout import ADC_COUNTS, FINGERTIP_RATE, TAXELS
from firstcontact.twin.objects import BLOCKS, OBJECTS
from firstcontact.twin.stream import StreamPinch, TwinStream

CONDITIONS = ("paper-rig", "everyday")
#: Six standard deviations between two readings of an unloaded sheet, counts.
SHEET_STEP = 11


@cache
def streamed(condition: str) -> tuple[NDArray[np.uint16], tuple[StreamPinch, ...]]:
    """Half a minute, and the pinches that are whole in it."""
    stream = TwinStream(condition, seed=6)
    scans = stream.read(round(30 * FINGERTIP_RATE))
    return scans, tuple(stream.pinches)[:-1]


@settings(max_examples=15)
@given(st.lists(st.integers(0, 9000), max_size=6))
def test_same_seed_same_scans_however_they_are_read(cuts: list[int]) -> None:
    stream = TwinStream("paper-rig", seed=6)
    edges = [0, *sorted(cuts), 9000]
    parts = []
    for a, b in pairwise(edges):
        assert stream.sample == a
        parts.append(stream.read(b - a))
    assert (np.concatenate(parts) == streamed("paper-rig")[0][:9000]).all()


def test_another_seed_is_another_stream() -> None:
    assert (TwinStream(seed=7).read(5000) != streamed("paper-rig")[0][:5000]).any()


@pytest.mark.parametrize("condition", CONDITIONS)
def test_scans_are_counts_and_strips(condition: str) -> None:
    scans, pinches = streamed(condition)
    assert scans.dtype == np.uint16
    assert scans[:, :4].max() < ADC_COUNTS
    assert set(np.unique(scans[:, 4:])) == {0, 1}
    assert len(pinches) > 10


@pytest.mark.parametrize("condition", CONDITIONS)
def test_the_truth_of_each_pinch_is_what_the_strips_show(condition: str) -> None:
    scans, pinches = streamed(condition)
    ends = [p.start for p in pinches[1:]] + [len(scans)]
    for pinch, end in zip(pinches, ends, strict=True):
        strips = scans[pinch.start : end, 4:]
        assert [c.sample for c in pinch.truth] == sorted(c.sample for c in pinch.truth)
        for contact in pinch.truth:
            assert contact.sample == pinch.start + strips[:, contact.finger].argmax()
        assert len(pinch.truth) == 2


@pytest.mark.parametrize("condition", CONDITIONS)
def test_each_pinch_runs_up_touches_holds_lets_go_and_rests(condition: str) -> None:
    scans, pinches = streamed(condition)
    for pinch, following in pairwise(pinches):
        first = pinch.truth[0].sample
        assert 0.13 < (first - pinch.start) / FINGERTIP_RATE < 0.3
        strips = scans[pinch.start : following.start, 4:].all(axis=1)
        assert 0.3 < strips.sum() / FINGERTIP_RATE < 1.2
        rest = scans[following.start - round(0.6 * FINGERTIP_RATE) : following.start]
        assert not rest[:, 4:].any()
        # The hum and the electronics alone.
        assert rest[:, :2].astype(float).std() < 1.5
        running = scans[first - round(0.12 * FINGERTIP_RATE) : first, :2].astype(float)
        assert (running.std(axis=0) > rest[:, :2].astype(float).std(axis=0)).all()
        squeezed = scans[first + round(0.3 * FINGERTIP_RATE), 2:4].astype(int)
        assert (squeezed > rest[-1, 2:4].astype(int) + 100).all()


@pytest.mark.parametrize("condition", CONDITIONS)
def test_nothing_jumps_where_one_pinch_follows_another(condition: str) -> None:
    scans, pinches = streamed(condition)
    for pinch in pinches:
        around = scans[pinch.start - 60 : pinch.start + 60].astype(int)
        assert np.ptp(around[:, :2], axis=0).max() < 20
        turns = around[:, 2:4].reshape(-1, TAXELS, 2)
        assert np.abs(np.diff(turns, axis=0)).max() <= SHEET_STEP


def test_every_object_has_its_turn_in_each_round() -> None:
    stream = TwinStream(objects=["block 10", BLOCKS[4], "apple 1"], seed=1)
    while len(stream.pinches) < 9:
        stream.read(1000)
    names = [p.label.object for p in list(stream.pinches)[:9]]
    for k in range(0, 9, 3):
        assert sorted(names[k : k + 3]) == ["apple 1", "block 10", "block 60"]


def test_a_chosen_object_is_taken_from_the_next_closing_on() -> None:
    stream = TwinStream(seed=2)
    stream.choose("block 29")
    while len(stream.pinches) < 3:
        stream.read(1000)
    stream.choose(None)
    while len(stream.pinches) < 3 + len(OBJECTS):
        stream.read(1000)
    labels = [p.label for p in stream.pinches]
    assert [la.object for la in labels[:3]] == ["block 29"] * 3
    assert labels[0].shore_a == 29
    assert sorted(la.object for la in labels[3:]) == sorted(OBJECTS), "the plan goes on"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("lab", None, 0), "'lab'"),
        (("paper-rig", ["pear"], 0), "'pear' is not known: use one of block 10"),
        (("paper-rig", [], 0), "no objects"),
        (("paper-rig", None, -1), "seed is -1"),
    ],
)
def test_what_cannot_be_streamed_is_refused(
    arguments: tuple[str, list[str] | None, int], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        TwinStream(*arguments)
    with pytest.raises(InputError, match="'pear'"):
        TwinStream().choose("pear")
