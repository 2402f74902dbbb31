"""Tests of the protocol's bytes in Python; ``tests/firmware`` compares the C code."""

import struct
import tracemalloc
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numbered import frames

from firstcontact.device import protocol
from firstcontact.device.protocol import (
    LONGEST,
    MARKER_BYTES,
    Decoder,
    Frame,
    FrameError,
    FrameType,
    decode,
    encode,
    stuff,
    unstuff,
)
from prediction_payloads import read_samples

#: Runs around the lengths where COBS changes, with and without zeros.
HARD = st.lists(
    st.one_of(
        st.just(b"\0"),
        st.integers(252, 256).map(lambda n: b"\x01" * n),
        st.integers(507, 510).map(lambda n: b"\xff" * n),
        st.binary(max_size=5),
    ),
    max_size=6,
).map(b"".join)


def reference_unstuff(stuffed: bytes) -> bytes:
    """Decode COBS as its paper describes it, byte by byte."""
    out = b""
    place = 0
    while place < len(stuffed):
        code = stuffed[place]
        out += stuffed[place + 1 : place + code]
        place += code
        if code < 255 and place < len(stuffed):
            out += b"\0"
    return out


@given(st.one_of(st.binary(max_size=1000), HARD))
def test_stuffed_bytes_have_no_zero_and_come_back(data: bytes) -> None:
    stuffed = stuff(data)
    assert 0 not in stuffed
    assert len(stuffed) <= len(data) + 1 + len(data) // 254
    assert unstuff(stuffed) == data == reference_unstuff(stuffed)


@given(st.binary(max_size=300))
def test_any_bytes_are_unstuffed_or_refused(stuffed: bytes) -> None:
    try:
        data = unstuff(stuffed)
    except FrameError:
        return
    assert data == reference_unstuff(stuffed)


@given(st.binary(max_size=100), st.data())
def test_the_crc_is_that_of_zlib_and_finds_any_changed_byte(
    payload: bytes, data: st.DataObject
) -> None:
    body = unstuff(encode(FrameType.MARK, 7, payload)[:-1])
    assert struct.unpack("<I", body[-4:])[0] == zlib.crc32(body[:-4])
    place = data.draw(st.integers(0, len(body) - 1))
    other = bytes([body[place] ^ data.draw(st.integers(1, 255))])
    with pytest.raises(FrameError, match="CRC"):
        decode(stuff(body[:place] + other + body[place + 1 :]))


@given(st.text(max_size=400))
def test_marker_is_cut_at_a_character_boundary(text: str) -> None:
    cut = protocol.marker_text(text)
    encoded = text.encode()
    assert encoded.startswith(cut)
    assert len(cut) <= MARKER_BYTES
    # Only a character that does not fit is missing.
    assert cut == encoded or len(cut) + len(text[len(cut.decode())].encode()) > MARKER_BYTES
    assert protocol.read_marker(protocol.marker_payload(2**32 + 9, text)) == (9, cut.decode())


@given(
    first=st.integers(0, 2**40),
    overflow=st.integers(0, 2**40),
    n=st.integers(1, 5),
    channels=st.integers(1, 20),
)
def test_samples_round_trip(first: int, overflow: int, n: int, channels: int) -> None:
    data = np.arange(n * channels, dtype=np.int16).reshape(n, channels) * 2731
    payload = protocol.samples_payload(first, overflow, data)
    back = read_samples(payload, channels)
    assert (back.first_sample, back.overflow) == (first % 2**32, overflow % 2**32)
    np.testing.assert_array_equal(back.data, data)
    for wrong in (payload[:-1], payload + b"\0", payload[:8], payload[:9], b""):
        with pytest.raises(FrameError):
            read_samples(wrong, channels)
    with pytest.raises(FrameError, match=rf"\b{n}\b.*\b{channels + 1}\b"):
        read_samples(payload, channels + 1)


def test_other_payloads_round_trip_or_are_refused() -> None:
    descriptor = protocol.descriptor_payload(2**32 - 1, "Größe", 3)
    assert protocol.read_descriptor(descriptor) == (3, 2**32 - 1, "Größe")
    assert protocol.read_stopped(protocol.stopped_payload(2**32 + 1, 5)) == (1, 5)
    for read_payload, payload in (
        (protocol.read_descriptor, b"\1\0\0\0"),
        (protocol.read_descriptor, descriptor[:-2]),  # half a character
        (protocol.read_marker, b"\0\0\0"),
        (protocol.read_marker, b"\0\0\0\0\xff"),
        (protocol.read_stopped, b"\0" * 7),
        (protocol.read_stopped, b"\0" * 9),
    ):
        with pytest.raises(FrameError):
            read_payload(payload)


#: The fault is made in the middle one.
STREAM = frames(0, 25)
BYTES = b"".join(STREAM)
START = len(b"".join(STREAM[:2]))
FAULTY = range(START, START + len(STREAM[2]))


def decoded(data: bytes) -> tuple[Decoder, list[Frame]]:
    decoder = Decoder()
    return decoder, decoder.feed(data)


def lost_counters(out: list[Frame]) -> set[int]:
    """Return the counters of the missing frames. Assert that all other frames are unchanged."""
    for frame in out:
        assert frame == decode(STREAM[frame.counter][:-1])
    return set(range(len(STREAM))) - {f.counter for f in out}


@pytest.mark.parametrize("start", range(1, len(STREAM[0])))
def test_partial_first_frame_is_not_counted_as_damaged(start: int) -> None:
    decoder, out = decoded(BYTES[start:])
    assert lost_counters(out) == {0}
    assert decoder.bad == 0


@pytest.mark.parametrize("place", FAULTY)
def test_flipped_byte_loses_its_frames(place: int) -> None:
    for flip in (0x01, 0x80, 0xFF, BYTES[place]):
        if flip == 0:
            continue
        flipped = bytes([BYTES[place] ^ flip])
        decoder, out = decoded(BYTES[:place] + flipped + BYTES[place + 1 :])
        joined = place == FAULTY[-1]  # the zero is gone
        assert lost_counters(out) == ({2, 3} if joined else {2})
        # A new zero cuts the frame in two, but where it stands beside another.
        cut = flip == BYTES[place] and FAULTY[0] < place < FAULTY[-2]
        assert decoder.bad == (2 if cut else 1)


def test_line_without_zeros_is_one_bad_frame_in_constant_memory() -> None:
    decoder = Decoder()
    decoder.feed(STREAM[0])
    noise = b"\x11" * 1000
    tracemalloc.start()
    assert not any(decoder.feed(noise) for _ in range(1000))
    assert tracemalloc.get_traced_memory()[0] < 4 * LONGEST
    tracemalloc.stop()
    assert decoder.bad == 0, "it has not ended yet"
    assert [f.counter for f in decoder.feed(b"\0" + STREAM[1])] == [1]
    assert decoder.bad == 1


def test_partial_frame_after_a_restart_is_not_counted() -> None:
    decoder, _ = decoded(BYTES[: START + 5])
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
