"""Tests of the assembler: exact counts of lost, repeated and late frames, and of restarts."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numbered import CHANNELS, DESCRIPTOR, check, frames, numbered, stretches

from firstcontact.core import Finger
from firstcontact.device import protocol
from firstcontact.device.assembler import Assembled, Assembler, Counts
from firstcontact.device.descriptor import DeviceEstimate, DevicePrediction
from firstcontact.device.protocol import FrameType, NextSamples, encode
from prediction_payloads import contact_payload, estimate_payload, late_payload

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


def late(counter: int, skipped: int, unheard: int) -> bytes:
    return encode(FrameType.LATE, counter, late_payload(skipped, unheard))


def stopped(counter: int, sample: int, overflow: int = 0) -> bytes:
    return encode(FrameType.STOPPED, counter, protocol.stopped_payload(sample, overflow))


#: What happens to an assembler: bytes that arrive, or a call of the host.
Step = bytes | Callable[[Assembler], None]
OTHER_COLUMNS = protocol.samples_payload(5, 0, np.zeros((5, 15), np.int16))
#: Steps, the epochs and sample numbers of the blocks, and the counts.
CASES: dict[str, tuple[list[Step], list[tuple[int, int, int]], Counts]] = {
    "gap": (
        [descriptor(), *frames(0, 15, 1), *frames(25, 25, 6)],
        [(0, 0, 15), (0, 25, 50)],
        Counts(40, lost_samples=10, lost_frames=2),
    ),
    "samples dropped by the device": (
        [*(descriptor(), *frames(0, 10, 1, 3), *frames(17, 5, 3, 10)), stopped(4, 30, 18)],
        [(0, 0, 10), (0, 17, 22)],
        Counts(15, lost_samples=15, overflow_samples=15),
    ),
    "stop counts losses at the end": (
        [descriptor(), *frames(0, 35, 1), stopped(11, 50)],
        [(0, 0, 35)],
        Counts(35, lost_samples=15, lost_frames=3),
    ),
    "late answers, with a restart": (
        [
            *(descriptor(), late(1, LAST, 7), late(2, 4, 9)),
            *(descriptor(2), late(1, 3, 0), late(2, 4, 0), encode(FrameType.LATE, 3, b"short")),
        ],
        [],
        Counts(late_answers=6, unheard_samples=2, malformed_frames=1),
    ),
    **{
        f"new frame repeats {n} samples": (
            [descriptor(), *frames(0, 20, 1), *frames(20 - n, 1, 5), *frames(20, 5, 6)],
            [(0, 0, 25)],
            Counts(25, doubled_frames=1),
        )
        for n in (1, 2, 5, 20)
    },
    **{
        f"frame counter wraps, {n} missing": (
            [descriptor(1, LAST - 3), *frames(0, 10, LAST - 2), *frames(10 + 5 * n, 40, LAST + n)],
            [(0, 0, 10), (0, 10 + 5 * n, 50 + 5 * n)] if n else [(0, 0, 50)],
            Counts(50, lost_samples=5 * n, lost_frames=n),
        )
        for n in (0, 1, 2)
    },
    "unknown frame": (
        [descriptor(), encode(0x7F, 1, b"of a later version"), *frames(0, 10, 2)],
        [(0, 0, 10)],
        Counts(10),
    ),
    "later frame of other columns": (
        [
            *(descriptor(), *frames(0, 5, 1)),
            *(encode(FrameType.SAMPLES, 2, OTHER_COLUMNS), *frames(10, 5, 3)),
        ],
        [(0, 0, 5), (0, 10, 15)],
        Counts(10, lost_samples=5, malformed_frames=1),
    ),
    "frames before the descriptor": (
        [*frames(500, 20, 90), descriptor(1, 94), *frames(520, 20, 95)],
        [(0, 520, 540)],
        Counts(20),
    ),
    "doubled descriptor": (
        [descriptor(), *frames(0, 100, 1), descriptor(), *frames(100, 10, 21)],
        [(0, 0, 110)],
        Counts(110, doubled_frames=1),
    ),
    **{
        f"restart with boot number {boot}": (
            [
                *(descriptor(), *frames(0, 100, 1)),
                *(Assembler.expect_descriptor, descriptor(boot), *frames(0, 100, 1)),
            ],
            [(0, 0, 100), (1, 0, 100)],
            Counts(200),
        )
        for boot in (1, 2)
    },
    # Frames before the next descriptor may be of a new start.
    "interruption": (
        [
            *(descriptor(), *frames(0, 100, 1), Assembler.interrupted),
            *(*frames(150, 10, 31), descriptor(1, 33), *frames(170, 30, 34)),
        ],
        [(0, 0, 100), (1, 170, 200)],
        Counts(130, lost_samples=70, lost_frames=12),
    ),
}


@pytest.mark.parametrize(("steps", "expected", "counts"), CASES.values(), ids=CASES)
def test_samples_and_losses_are_counted(
    steps: list[Step], expected: list[tuple[int, int, int]], counts: Counts
) -> None:
    line = Line(b"")
    for step in steps:
        if isinstance(step, bytes):
            line.feed(step)
        else:
            step(line.assembler)
    assert stretches(line.out.blocks) == expected
    assert line.counts == counts


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


def test_markers_have_unwrapped_sample_numbers() -> None:
    line = Line()
    line.feed(*frames(2**32 - 10, 10, 1))
    line.feed(encode(FrameType.MARKER, 3, protocol.marker_payload(2**32 + 4, "später")))
    (marker,) = line.out.markers
    assert (marker.sample, marker.text, marker.epoch) == (2**32 + 4, "später", 0)


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
    predictions, counts = predictions_of_frame(estimate_payload(estimate), FrameType.ESTIMATE)
    assert (predictions, counts) == ([estimate], Counts(70))


WRONG_ESTIMATES: tuple[dict[str, float], ...] = (
    *({"value": 1e38, "high": 1e38}, {"value": -500.0, "low": -500.0}, {"value": math.nan}),
    *({"high": math.inf}, {"low": 39.0, "high": 22.0}, {"low": 31.0}, {"high": 30.0}),
    *({"contact": -1}, {"contact": 1059}, {"samples": 60}, {"decided": 1060 + MINUTE + 1}),
    {"contact": 2**31 - 1, "decided": 2**31 - 1},
)
WRONG_CONTACTS = (-1, 1058), (1059, 1058), (2**31, 2**31 + 5), (0, 1060 + MINUTE + 1)


@pytest.mark.parametrize(
    ("kind", "payload"),
    [
        *(
            (FrameType.ESTIMATE, estimate_payload(replace(ESTIMATE, **wrong)))  # type: ignore[arg-type]
            for wrong in WRONG_ESTIMATES
        ),
        *((FrameType.CONTACT, contact_payload(Finger.INDEX, *w, True)) for w in WRONG_CONTACTS),
    ],
)
def test_invalid_prediction_is_counted_as_malformed(kind: FrameType, payload: bytes) -> None:
    predictions, counts = predictions_of_frame(payload, kind)
    assert (predictions, counts) == ([], Counts(70, malformed_frames=1))


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
