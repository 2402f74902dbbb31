"""Tests of the decoder with streams that are cut and damaged anywhere."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numbered import frames

from firstcontact.device import Decoder, FrameType, encode
from firstcontact.device._protocol import LONGEST, Frame, decode

#: The fault is made in the middle one.
STREAM = frames(0, 25)
BYTES = b"".join(STREAM)
START = len(b"".join(STREAM[:2]))
FAULTY = range(START, START + len(STREAM[2]))


def decode_pieces(data: bytes, pieces: int = 1 << 20) -> tuple[Decoder, list[Frame]]:
    decoder = Decoder()
    out = []
    for start in range(0, len(data), pieces):
        out += decoder.feed(data[start : start + pieces])
    return decoder, out


def lost_counters(out: list[Frame]) -> set[int]:
    """Return the counters of the missing frames. Assert that all other frames are unchanged."""
    for frame in out:
        assert frame == decode(STREAM[frame.counter][:-1])
    return set(range(len(STREAM))) - {f.counter for f in out}


@pytest.mark.parametrize("pieces", [1, 2, 3, 7, 190, 191, 192])
def test_pieces_of_any_size_give_the_same_frames(pieces: int) -> None:
    decoder, out = decode_pieces(BYTES, pieces)
    assert lost_counters(out) == set()
    assert decoder.bad == 0


@pytest.mark.parametrize("cut", range(len(BYTES)))
def test_a_cut_at_every_byte_changes_nothing(cut: int) -> None:
    decoder = Decoder()
    assert lost_counters(decoder.feed(BYTES[:cut]) + decoder.feed(BYTES[cut:])) == set()
    assert decoder.bad == 0


@pytest.mark.parametrize("start", range(1, len(STREAM[0])))
def test_partial_first_frame_is_not_counted_as_damaged(start: int) -> None:
    decoder, out = decode_pieces(BYTES[start:])
    assert lost_counters(out) == {0}
    assert decoder.bad == 0


@pytest.mark.parametrize("place", FAULTY)
def test_flipped_byte_loses_its_frames(place: int) -> None:
    for flip in (0x01, 0x80, 0xFF, BYTES[place]):
        if flip == 0:
            continue
        flipped = bytes([BYTES[place] ^ flip])
        decoder, out = decode_pieces(BYTES[:place] + flipped + BYTES[place + 1 :])
        joined = place == FAULTY[-1]  # the zero is gone
        assert lost_counters(out) == ({2, 3} if joined else {2})
        # A new zero cuts the frame in two, but where it stands beside another.
        cut = flip == BYTES[place] and FAULTY[0] < place < FAULTY[-2]
        assert decoder.bad == (2 if cut else 1)


@pytest.mark.parametrize("place", FAULTY)
@pytest.mark.parametrize("byte", [0x00, 0x01, 0xFF])
def test_inserted_byte_loses_its_frame(place: int, byte: int) -> None:
    decoder, out = decode_pieces(BYTES[:place] + bytes([byte]) + BYTES[place:])
    between = byte == 0 and place in (FAULTY[0], FAULTY[-1])  # a zero beside a zero is nothing
    assert lost_counters(out) == (set() if between else {2})
    assert decoder.bad == (0 if between else 2 if byte == 0 else 1)


@pytest.mark.parametrize("place", FAULTY)
def test_deleted_byte_loses_its_frames(place: int) -> None:
    decoder, out = decode_pieces(BYTES[:place] + BYTES[place + 1 :])
    assert lost_counters(out) == ({2, 3} if place == FAULTY[-1] else {2})
    assert decoder.bad == 1


MANY = frames(0, 600)
ENDS = np.cumsum([len(f) for f in MANY])


@given(st.binary(min_size=1000, max_size=1000), st.integers(len(MANY[0]), 10_000))
def test_burst_loses_only_the_overwritten_frames(burst: bytes, place: int) -> None:
    first_frame, last_frame = np.searchsorted(ENDS, [place, place + len(burst) - 1], "right")
    touched = set(range(first_frame, last_frame + 1))
    # Where the burst ends on the zero of a frame, the next is joined to it.
    joined = {int(last_frame) + 1} if place + len(burst) == ENDS[last_frame] else set()
    data = b"".join(MANY)
    decoder, out = decode_pieces(data[:place] + burst + data[place + len(burst) :])
    received = {f.counter for f in out}
    untouched = set(range(len(MANY))) - touched
    assert untouched - joined <= received <= untouched
    assert 1 <= decoder.bad <= burst.count(0) + 1


def test_line_without_zeros_is_one_bad_frame_in_constant_memory() -> None:
    decoder = Decoder()
    decoder.feed(STREAM[0])
    for _ in range(1000):
        assert decoder.feed(b"\x11" * 1000) == []
        assert len(decoder._rest) <= LONGEST
    assert decoder.bad == 0, "it has not ended yet"
    assert [f.counter for f in decoder.feed(b"\0" + STREAM[1])] == [1]
    assert decoder.bad == 1


def test_repeated_zeros_are_ignored() -> None:
    decoder, out = decode_pieces(b"\0\0".join([*STREAM, b"\0"]))
    assert lost_counters(out) == set()
    assert decoder.bad == 0


def test_partial_frame_after_a_restart_is_not_counted() -> None:
    decoder, _ = decode_pieces(BYTES[: START + 5])
    decoder.restart()
    assert lost_counters(decoder.feed(BYTES[START + 9 :])) == {0, 1, 2}
    assert decoder.bad == 0
    decoder.feed(b"\x05\x05\0")
    decoder.restart()
    assert decoder.bad == 1, "what was counted stays"


@given(st.integers(0, 255), st.integers(0, 2**32 - 1), st.binary(max_size=600), st.data())
def test_any_frame_round_trips_in_any_pieces(
    kind: int, counter: int, payload: bytes, data: st.DataObject
) -> None:
    wire = encode(kind, counter, payload) + encode(FrameType.STOP, 0)
    cut = data.draw(st.integers(0, len(wire)))
    decoder = Decoder()
    out = decoder.feed(wire[:cut]) + decoder.feed(wire[cut:])
    assert out == [Frame(kind, counter, payload), Frame(FrameType.STOP, 0, b"")]
