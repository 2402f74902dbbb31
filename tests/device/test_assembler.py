"""Tests of the assembler: exact counts of lost, repeated and late frames, and of restarts."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numbered import CHANNELS, DESCRIPTOR, check, frames, numbered

from firstcontact.core import Finger
from firstcontact.device import (
    Assembler,
    DeviceContact,
    DeviceEstimate,
    DevicePrediction,
    FrameType,
    encode,
)
from firstcontact.device import _protocol as protocol
from firstcontact.device._assembler import Assembled, Counts
from firstcontact.device._descriptor import contact_payload, estimate_payload
from firstcontact.device._protocol import NextSamples

LAST = 2**32 - 1


def descriptor(boot: int = 1, counter: int = 0) -> bytes:
    return encode(
        FrameType.DESCRIPTOR, counter, protocol.descriptor_payload(boot, DESCRIPTOR.to_text())
    )


class Line:
    """Decoder and assembler of one line, with all blocks so far."""

    def __init__(self, *wire: bytes) -> None:
        self.assembler = Assembler()
        self.out = Assembled()
        self.feed(*(wire or (descriptor(),)))

    def feed(self, *wire: bytes, is_compiled: bool = True) -> Assembled:
        data = b"".join(wire)
        if is_compiled:
            new = self.assembler.feed(data)
        else:
            new = self.assembler.take(self.assembler.decoder.feed(data))
        self.out.blocks += new.blocks
        self.out.markers += new.markers
        return new

    @property
    def counts(self) -> Counts:
        """Counts of the assembler. Reading them checks the numbers in all blocks."""
        assert check(self.out.blocks) == self.assembler.counts.samples
        return self.assembler.counts

    @property
    def stretches(self) -> list[tuple[int, int, int]]:
        return [(b.epoch, b.first_sample, b.end) for b in self.out.blocks]


def test_consecutive_frames_are_one_block() -> None:
    line = Line()
    line.feed(*frames(7, 98, 1))
    assert line.stretches == [(0, 7, 105)]
    assert line.counts == Counts(samples=98)


def test_a_gap_begins_a_block_and_is_counted() -> None:
    line = Line()
    wire = frames(0, 50, 1)
    line.feed(*wire[:3], *wire[5:])
    assert line.stretches == [(0, 0, 15), (0, 25, 50)]
    assert line.counts == Counts(samples=40, lost_samples=10, lost_frames=2)


def test_samples_dropped_by_the_device_are_lost() -> None:
    line = Line()
    line.feed(*frames(0, 10, 1, overflow=3), *frames(17, 5, 3, overflow=10))
    line.feed(encode(FrameType.STOPPED, 4, protocol.stopped_payload(30, 18)))
    assert line.counts == Counts(samples=15, lost_samples=15, overflow_samples=15)


def test_late_answers_are_counted_from_the_start_of_the_stream() -> None:
    def late(counter: int, skipped: int, unheard: int) -> bytes:
        return encode(FrameType.LATE, counter, protocol.late_payload(skipped, unheard))

    line = Line(descriptor(), late(1, LAST, 7), late(2, 4, 9))
    assert line.counts == Counts(late_answers=5, unheard_samples=2)
    line.feed(descriptor(boot=2), late(1, 3, 0), late(2, 4, 0), encode(FrameType.LATE, 3, b"short"))
    assert line.counts == Counts(late_answers=6, unheard_samples=2, malformed_frames=1)


@given(st.lists(st.integers(1, 30), unique=True, max_size=20), st.data())
def test_lost_doubled_and_late_frames_are_each_counted_once(
    lost_frames: list[int], data: st.DataObject
) -> None:
    wire = frames(0, 200, 1)
    delivered = [k for k in range(len(wire)) if k not in lost_frames]
    # Some come again later, or only later: up to four places.
    repeated = data.draw(st.lists(st.sampled_from(delivered[:-5]), unique=True, max_size=5))
    order = list(delivered)
    for k in repeated:
        order.insert(order.index(k) + data.draw(st.integers(1, 4)), k)
    line = Line()
    for k in order:
        line.feed(wire[k])
    assert line.counts == Counts(
        samples=5 * len(delivered),
        lost_samples=5 * len(set(lost_frames)),
        lost_frames=len(set(lost_frames)),
        doubled_frames=len(repeated),
    )


@pytest.mark.parametrize("repeated", [1, 2, 5, 20])
def test_new_frame_that_repeats_samples_is_ignored(repeated: int) -> None:
    line = Line()
    line.feed(*frames(0, 20, 1), *frames(20 - repeated, 1, 5), *frames(20, 5, 6))
    assert line.stretches == [(0, 0, 25)]
    assert line.counts == Counts(samples=25, doubled_frames=1)


@pytest.mark.parametrize("offset", range(0, 12))
def test_sample_numbers_continue_beyond_32_bits(offset: int) -> None:
    line = Line()
    first = 2**32 - offset
    line.feed(*frames(first, 20, 1))
    assert line.assembler.counts == Counts(samples=20)
    unwrapped = first if offset else 0
    assert line.stretches == [(0, unwrapped, unwrapped + 20)]
    check(line.out.blocks)


def test_sample_numbers_wrap_repeatedly() -> None:
    line = Line()
    step = 2**31 - 5
    numbers = [k * step for k in range(9)]
    for k, number in enumerate(numbers):
        line.feed(*frames(number, 5, 1 + k))
    assert [s[1] for s in line.stretches] == numbers
    assert line.counts.lost_samples == numbers[-1] + 5 - 45


@pytest.mark.parametrize("missing", [0, 1, 2])
def test_the_frame_counter_wraps(missing: int) -> None:
    line = Line(descriptor(1, LAST - 3))
    wire = frames(0, 50, LAST - 2)
    line.feed(*wire[:2], *wire[2 + missing :])
    assert line.counts.lost_frames == missing
    assert line.counts.samples == 50 - 5 * missing
    assert line.counts.doubled_frames == 0


def test_unknown_frames_are_counted() -> None:
    line = Line()
    line.feed(encode(0x7F, 1, b"what may come"), *frames(0, 10, 2))
    assert line.counts == Counts(samples=10)


def test_frames_before_the_descriptor_are_ignored() -> None:
    line = Line(*frames(500, 20, 90), descriptor(1, 94), *frames(520, 20, 95))
    assert line.stretches == [(0, 520, 540)]
    assert line.counts == Counts(samples=20)


def test_reset_starts_an_epoch() -> None:
    line = Line()
    line.feed(*frames(0, 100, 1))
    line.assembler.expect_descriptor()
    line.feed(descriptor(2), *frames(0, 100, 1))
    assert line.stretches == [(0, 0, 100), (1, 0, 100)]
    assert line.counts == Counts(samples=200)


def test_restart_with_the_same_boot_number_starts_an_epoch() -> None:
    line = Line()
    line.feed(*frames(0, 100, 1))
    line.assembler.expect_descriptor()
    line.feed(descriptor(1, 0), *frames(0, 100, 1))
    assert [s[0] for s in line.stretches] == [0, 1]
    assert line.counts == Counts(samples=200)


def test_doubled_descriptor_starts_no_epoch() -> None:
    line = Line()
    line.feed(*frames(0, 100, 1), descriptor(1, 0), *frames(100, 10, 21))
    assert line.counts == Counts(samples=110, doubled_frames=1)
    assert line.assembler.epoch == 0


def test_interruption_starts_a_new_epoch() -> None:
    line = Line()
    line.feed(*frames(0, 100, 1))
    line.assembler.interrupted()
    # What it had sent meanwhile is not known to be of this start before it has said so.
    line.feed(*frames(150, 10, 31), descriptor(1, 33), *frames(170, 30, 34))
    assert line.stretches == [(0, 0, 100), (1, 170, 200)]
    assert line.counts == Counts(samples=130, lost_samples=70, lost_frames=12)


def test_markers_have_unwrapped_sample_numbers() -> None:
    line = Line()
    line.feed(*frames(2**32 - 10, 10, 1))
    line.feed(encode(FrameType.MARKER, 3, protocol.marker_payload(2**32 + 4, "später")))
    (marker,) = line.out.markers
    assert (marker.sample, marker.text, marker.epoch) == (2**32 + 4, "später", 0)


def test_stopped_frame_counts_losses_at_the_end() -> None:
    line = Line()
    wire = frames(0, 50, 1)
    line.feed(*wire[:7])
    assert line.feed(encode(FrameType.STOPPED, 11, protocol.stopped_payload(50, 0))).stopped
    assert line.counts == Counts(samples=35, lost_samples=15, lost_frames=3)


def test_later_frame_of_other_columns_is_counted() -> None:
    line = Line()
    payload = protocol.samples_payload(5, 0, np.zeros((5, 15), np.int16))
    line.feed(*frames(0, 5, 1), encode(FrameType.SAMPLES, 2, payload), *frames(10, 5, 3))
    assert line.counts == Counts(samples=10, lost_samples=5, malformed_frames=1)


ESTIMATE = DeviceEstimate(Finger.THUMB, 1000, 59, 1058, 30.5, 22.0, 39.0, False, False, 4e-4, 0)
MINUTE = round(60 * DESCRIPTOR.layout.rate)


def predictions_of_frame(
    payload: bytes, kind: FrameType, next_sample: int = 1060
) -> tuple[list[DevicePrediction], Counts]:
    """Return the predictions from a frame that comes between two samples frames, and the counts."""
    line = Line()
    line.feed(*frames(next_sample - 60, 60, 1))
    out = line.feed(encode(kind, 13, payload), *frames(next_sample, 10, 14))
    return out.predictions, line.counts


@pytest.mark.parametrize("flags", [{}, {"refused": True, "value": 0.0, "low": 0.0, "high": 0.0}])
def test_estimate_is_passed_on_unchanged(flags: dict[str, float]) -> None:
    estimate = replace(ESTIMATE, **flags)  # type: ignore[arg-type]
    assert predictions_of_frame(estimate_payload(estimate), FrameType.ESTIMATE) == (
        [estimate],
        Counts(70),
    )


@pytest.mark.parametrize(
    "wrong",
    [
        {"value": 1e38, "high": 1e38},
        {"value": -500.0, "low": -500.0},
        {"value": math.nan},
        {"high": math.inf},
        {"low": 39.0, "high": 22.0},
        {"low": 31.0},
        {"high": 30.0},
        {"contact": -1},
        {"contact": 1059},
        {"samples": 60},
        {"decided": 1060 + MINUTE + 1},
        {"contact": 2**31 - 1, "decided": 2**31 - 1},
    ],
)
def test_invalid_estimate_is_counted_as_malformed(wrong: dict[str, float]) -> None:
    payload = estimate_payload(replace(ESTIMATE, **wrong))  # type: ignore[arg-type]
    assert predictions_of_frame(payload, FrameType.ESTIMATE) == (
        [],
        Counts(samples=70, malformed_frames=1),
    )


@pytest.mark.parametrize(
    ("sample", "decided"), [(-1, 1058), (1059, 1058), (2**31, 2**31 + 5), (0, 1060 + MINUTE + 1)]
)
def test_contact_outside_the_samples_is_counted_as_malformed(sample: int, decided: int) -> None:
    payload = contact_payload(Finger.INDEX, sample, decided, True)
    assert predictions_of_frame(payload, FrameType.CONTACT) == (
        [],
        Counts(samples=70, malformed_frames=1),
    )


def test_contact_is_accepted_after_a_long_interruption() -> None:
    line = Line(descriptor(), *frames(0, 60, 1))
    line.assembler.interrupted()
    first = 10 * MINUTE
    payload = contact_payload(Finger.INDEX, first, first + 12, True)
    out = line.feed(descriptor(counter=50), encode(FrameType.CONTACT, 51, payload))
    assert out.predictions == [DeviceContact(Finger.INDEX, first, first + 12, True, 1)]
    assert line.feed(*frames(first + 20, 5, 52)).blocks[0].epoch == 1
    assert line.counts.malformed_frames == 0


#: Changes of a wire: what is done to the frame at an index, with a byte.
DAMAGE = st.tuples(
    st.sampled_from(("drop", "double", "flip", "cut", "grow", "split")),
    st.integers(0, 60),
    st.integers(0, 255),
)


def damaged(wire: list[bytes], damage: list[tuple[str, int, int]]) -> bytes:
    """Return frames as bytes, after changes of some of them."""
    wire = list(wire)
    for kind, index, byte in damage:
        k = index % len(wire)
        frame, place = wire[k], (7 * index) % max(len(wire[k]), 1)
        changed = {
            "drop": b"",
            "double": 2 * frame,
            "flip": frame[:place] + bytes([byte]) + frame[place + 1 :],
            "cut": frame[:place],
            "grow": frame[:place] + bytes([byte]) + frame[place:],
            "split": frame[:place] + b"\0" + frame[place:],
        }
        wire[k] = changed[kind]
    return b"".join(wire)


@given(
    st.lists(DAMAGE, max_size=4),
    st.lists(st.integers(0, 6000), max_size=12),
    st.sampled_from((0, 2**32 - 40, 2**33 + 5)),
)
def test_compiled_and_python_code_decode_alike(
    damage: list[tuple[str, int, int]], cuts: list[int], first: int
) -> None:
    counter = LAST - 9  # wraps on the way
    marker = encode(FrameType.MARKER, counter + 11, protocol.marker_payload(first + 40, "a word"))
    wire = damaged(
        [
            *frames(first, 48, counter + 1),
            marker,
            *frames(first + 48, 12, counter + 12, size=2),
            *frames(first + 63, 20, counter + 18, overflow=3),
            encode(FrameType.STOPPED, counter + 22, protocol.stopped_payload(first + 83, 3)),
            descriptor(2, 0),
            *frames(0, 30, 1),
        ],
        damage,
    )
    ends = sorted({cut % len(wire) for cut in cuts} | {len(wire)})
    pieces = [wire[a:b] for a, b in zip([0, *ends], ends, strict=False)]
    seen = []
    for is_compiled in (True, False):
        line = Line(descriptor(counter=counter))
        content = [line.feed(piece, is_compiled=is_compiled) for piece in pieces]
        blocks = [(b.epoch, b.first_sample, b.data.tobytes()) for c in content for b in c.blocks]
        markers = [m for c in content for m in c.markers]
        seen.append((blocks, markers, [c.stopped for c in content], line.counts))
        seen[-1] += (line.assembler.decoder.bad, line.assembler.next_sample)
    assert seen[0] == seen[1]


def test_compiled_code_takes_all_samples_that_follow_one_another() -> None:
    line = Line()
    line.feed(*frames(0, 10, 1))
    wire = b"".join(frames(10, 5_000, 3))
    expected = NextSamples(CHANNELS, 3, 10, 0)
    count, samples = line.assembler.decoder.feed_samples(wire + wire[:7], expected)
    assert (count, len(samples)) == (1_000, 5_000 * CHANNELS * 2)
    np.testing.assert_array_equal(
        np.frombuffer(samples, "<i2").reshape(-1, CHANNELS), numbered(10, 5_000)
    )
