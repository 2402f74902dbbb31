"""Tests of the streaming hand: reproducible, continuous, with true contacts."""

from collections.abc import Callable
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from firstcontact.core import Command, InputError
from firstcontact.core.layout import ADC_COUNTS, FINGERTIP_RATE, TAXELS
from firstcontact.twin import BLOCKS, TwinStream
from firstcontact.twin._stream import LONG_REST, StreamPinch
from firstcontact.twin.objects import OBJECTS

CONDITIONS = ("paper-rig", "everyday")
#: Six standard deviations between two readings of an unloaded sheet, counts.
SHEET_STEP = 11


@cache
def streamed(condition: str) -> tuple[NDArray[np.uint16], tuple[StreamPinch, ...]]:
    """Return half a minute of scans and the complete pinches in it."""
    stream = TwinStream(condition, seed=6)
    scans = stream.read(round(30 * FINGERTIP_RATE))
    return scans, tuple(stream.pinches)[:-1]


@settings(max_examples=6)
@given(st.lists(st.integers(0, 9000), max_size=6))
def test_same_seed_gives_the_same_scans_for_any_reads(cuts: list[int]) -> None:
    stream = TwinStream("paper-rig", seed=6)
    edges = [0, *sorted(cuts), 9000]
    parts = []
    for a, b in pairwise(edges):
        assert stream.sample == a
        parts.append(stream.read(b - a))
    assert (np.concatenate(parts) == streamed("paper-rig")[0][:9000]).all()


@pytest.mark.parametrize("condition", CONDITIONS)
def test_truth_of_each_pinch_matches_the_strips(condition: str) -> None:
    scans, pinches = streamed(condition)
    assert scans.dtype == np.uint16
    assert scans[:, :4].max() < ADC_COUNTS
    assert set(np.unique(scans[:, 4:])) == {0, 1}
    assert len(pinches) > 10
    ends = [p.start for p in pinches[1:]] + [len(scans)]
    for pinch, end in zip(pinches, ends, strict=True):
        strips = scans[pinch.start : end, 4:]
        assert [c.sample for c in pinch.truth] == sorted(c.sample for c in pinch.truth)
        for contact in pinch.truth:
            assert contact.sample == pinch.start + strips[:, contact.finger].argmax()
        assert len(pinch.truth) == 2


@pytest.mark.parametrize("condition", CONDITIONS)
def test_each_pinch_has_all_phases(condition: str) -> None:
    scans, pinches = streamed(condition)
    for pinch, following in pairwise(pinches):
        contact_sample = pinch.truth[0].sample
        assert 0.13 < (contact_sample - pinch.start) / FINGERTIP_RATE < 0.3
        strips = scans[pinch.start : following.start, 4:].all(axis=1)
        assert 0.3 < strips.sum() / FINGERTIP_RATE < 1.2
        rest_scans = scans[following.start - round(0.6 * FINGERTIP_RATE) : following.start]
        assert not rest_scans[:, 4:].any()
        # The hum and the electronics alone.
        assert rest_scans[:, :2].std() < 1.5
        running = scans[contact_sample - round(0.12 * FINGERTIP_RATE) : contact_sample, :2]
        assert (running.std(axis=0) > rest_scans[:, :2].std(axis=0)).all()
        squeezed = scans[contact_sample + round(0.3 * FINGERTIP_RATE), 2:4].astype(int)
        assert (squeezed > rest_scans[-1, 2:4].astype(int) + 50).all()


@pytest.mark.parametrize("condition", CONDITIONS)
def test_signal_is_continuous_between_pinches(condition: str) -> None:
    scans, pinches = streamed(condition)
    for pinch in pinches:
        around = scans[pinch.start - 60 : pinch.start + 60].astype(int)
        assert np.ptp(around[:, :2], axis=0).max() < 20
        turns = around[:, 2:4].reshape(-1, TAXELS, 2)
        assert np.abs(np.diff(turns, axis=0)).max() <= SHEET_STEP


def test_each_round_has_every_object() -> None:
    stream = TwinStream(objects=["block 10", BLOCKS[4], "apple 1"], seed=1)
    while len(stream.pinches) < 9:
        stream.read(1000)
    names = [p.label.object for p in list(stream.pinches)[:9]]
    for k in range(0, 9, 3):
        assert sorted(names[k : k + 3]) == ["apple 1", "block 10", "block 60"]


def test_chosen_object_applies_from_the_next_closing() -> None:
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
        (("lab", None, 0, 0.02), "'lab'"),
        (("paper-rig", ["pear"], 0, 0.02), "'pear' is not known: use one of block 10"),
        (("paper-rig", [], 0, 0.02), "no objects"),
        (("paper-rig", None, 0, -0.01), "latency is -0.01"),
    ],
)
def test_invalid_streams_are_refused(
    arguments: tuple[str, list[str] | None, int, float], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        TwinStream(*arguments)
    with pytest.raises(InputError, match="'pear'"):
        TwinStream().choose("pear")
    with pytest.raises(InputError) as caught:
        TwinStream(seed=-1)
    assert caught.value.parameter == "seed"


#: A closing that does as it is told.
Tell = Callable[[TwinStream], object]
#: Reads so many scans at a time.
STEP = 5
#: Closings that a commanded stream is watched for.
WATCHED = 4


def closings(
    tell: Tell | None = None, at: int = 1, place: str = "touched", **settings: float
) -> tuple[list[StreamPinch], NDArray[np.uint16], TwinStream]:
    """Return the first closings. One gets a command, at its first contact or its motor's start."""
    stream = TwinStream(seed=6, **settings)  # type: ignore[arg-type]
    parts = []
    while sum(p.end is not None for p in stream.pinches) < WATCHED:
        parts.append(stream.read(STEP))
        if tell is not None and len(stream.pinches) == at + 1:
            if place == "touched" and not stream.pinches[-1].truth:
                continue
            tell(stream)
            tell = None
    return list(stream.pinches)[:WATCHED], np.concatenate(parts), stream


@cache
def uncommanded() -> tuple[list[StreamPinch], NDArray[np.uint16]]:
    return closings()[:2]


def since_start(pinch: StreamPinch) -> tuple[object, ...]:
    """Return all properties of a pinch except its start."""
    truth = tuple((c.finger, c.sample - pinch.start) for c in pinch.truth)
    return pinch.label, truth, pinch.end - pinch.start, pinch.peak


def test_each_closing_has_its_peak_force_whatever_the_latency() -> None:
    pinches, scans = uncommanded()
    assert (closings(latency=0.08)[1] == scans).all()
    for pinch in pinches:
        # The hold's force and less than twice the stall force.
        assert 8.0 < pinch.peak < 24.0
        if pinch.end + 1000 < len(scans):
            assert scans[pinch.end - 1, 4:].all(), "held"
            assert not scans[pinch.end + 1000, 4:].any(), "let go"


@pytest.mark.parametrize("at", range(3))
def test_command_changes_the_peak_of_its_closing_only(at: int) -> None:
    as_drawn, _ = uncommanded()
    pinches, _, stream = closings(lambda s: s.command(Command(0.05, 2.0)), at)
    peaks = [(p.peak, q.peak) for p, q in zip(pinches, as_drawn, strict=True)]
    commanded_peak, drawn_peak = peaks.pop(at)
    assert commanded_peak < 0.6 * drawn_peak
    assert all(p == q for p, q in peaks)
    for k in {0, 1, 2, 3} - {at}:
        assert since_start(pinches[k]) == since_start(as_drawn[k])
    assert stream.ignored == 0


def test_release_opens_at_once_and_leaves_later_closings() -> None:
    as_drawn, _ = uncommanded()
    for place in ("touched", "start"):
        command_log: list[int] = []

        def tell(stream: TwinStream, command_log: list[int] = command_log) -> None:
            command_log.append(stream.sample)
            stream.release()
            stream.release()

        pinches, _, _ = closings(tell, 1, place)
        end = pinches[1].end
        # To the next piece and no longer.
        assert 0 <= end - command_log[0] - round(0.02 * FINGERTIP_RATE) <= 50
        if place == "start":
            assert pinches[1].truth == ()
            assert pinches[1].peak == 0.0
        assert since_start(pinches[2]) == since_start(as_drawn[2])


@pytest.mark.parametrize("place", ["rest", "start", "touched"])
def test_request_begins_a_whole_closing_at_once_and_a_long_rest(place: str) -> None:
    stream = TwinStream(seed=6)
    while place != "rest" and not stream.pinches:
        stream.read(STEP)
    while place == "touched" and not stream.pinches[-1].truth:
        stream.read(STEP)
    earlier, requested = len(stream.pinches), stream.sample
    stream.close()
    while len(stream.pinches) == earlier or stream.pinches[-1].end is None:
        stream.read(STEP)
    pinch = stream.pinches[-1]
    # Opening takes half a second at most, and a rest is longer.
    assert pinch.start - requested < (0.02 if place == "rest" else 0.6) * FINGERTIP_RATE
    assert {contact.finger for contact in pinch.truth} == {0, 1}
    stream.read(pinch.end + round(LONG_REST * FINGERTIP_RATE) - stream.sample)
    assert stream.pinches[-1] is pinch
    stream.close()
    stream.read(round(0.1 * FINGERTIP_RATE))
    assert stream.pinches[-1] is not pinch


def test_command_without_a_closing_is_counted_as_ignored() -> None:
    stream = TwinStream(seed=6)
    assert not stream.command(Command(0.0, 0.0))
    stream.release()
    stream.read(round(0.3 * FINGERTIP_RATE))
    assert not stream.command(Command(0.0, 0.0))
    assert stream.ignored == 2
    total = len(uncommanded()[1])
    remainder = stream.read(total - stream.sample)
    assert (remainder == uncommanded()[1][-len(remainder) :]).all()
    with pytest.raises(InputError, match="speed"):
        stream.command(Command(float("nan"), 1.0))


def test_command_overtaken_by_the_opening_is_counted_as_ignored() -> None:
    def late(stream: TwinStream) -> None:
        stream.release()
        assert not stream.command(Command(0.1, 1.0))

    assert closings(late)[2].ignored == 1
    # Nor does it come back to one whose effect would come after the hold.
    pinches, scans, stream = closings(lambda s: s.command(Command(0.0, 0.0)), latency=3.0)
    assert stream.ignored == 1
    assert pinches == uncommanded()[0]
    assert (scans == uncommanded()[1]).all()


@pytest.mark.parametrize("condition", CONDITIONS)
@settings(max_examples=5)
@given(
    st.lists(
        st.tuples(
            st.integers(1, 3000), st.none() | st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 50.0))
        ),
        max_size=12,
    ),
    st.sampled_from([0.0, 0.02, 0.08, 5.0]),
)
def test_closings_continue_after_any_orders(
    condition: str, orders: list[tuple[int, tuple[float, float] | None]], latency: float
) -> None:
    stream = TwinStream(condition, seed=6, latency=latency)
    for wait, order in orders:
        assert stream.read(wait).shape == (wait, 6)
        if order is None:
            stream.release()
        else:
            stream.command(Command(*order))
    count = len(stream.pinches)
    stream.read(round(6 * FINGERTIP_RATE))
    assert len(stream.pinches) > count


def test_household_stream_reports_lost_objects() -> None:
    breaks = TwinStream("paper-rig", ["potato crisp"], 1)
    breaks.read(15_000)
    assert breaks.pinches[0].lost == "broken"
    assert breaks.pinches[0].label.object == "potato crisp"
    holds = TwinStream("paper-rig", ["apple"], 1)
    holds.read(15_000)
    assert holds.pinches[0].end is not None
    assert holds.pinches[0].lost is None
    slips = TwinStream("paper-rig", ["hammer, at its handle"], 1)
    while not slips.command(Command(0.05, 1.0)):
        slips.read(50)
    slips.read(25_000)
    assert slips.pinches[0].lost == "dropped"
    with pytest.raises(InputError, match="use one of"):
        TwinStream("paper-rig", ["anvil"])
