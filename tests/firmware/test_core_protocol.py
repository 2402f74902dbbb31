"""The C core: protocol, filters, scan order and timing."""

import itertools
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from firmware_core import Core
from golden_frames import GOLDEN, Golden
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from firstcontact.chain import Reason
from firstcontact.core import Finger
from firstcontact.core.layout import ADC_COUNTS, FINGERTIP_RATE
from firstcontact.device import protocol
from firstcontact.device.descriptor import (
    DeviceContact,
    DeviceEstimate,
    read_contact,
    read_estimate,
)
from firstcontact.twin.sensor import DeviceFilter

#: Bytes with many zeros and with long runs without zeros, so that some runs reach 254.
RUNS = st.lists(
    st.one_of(
        st.binary(max_size=20), st.integers(1, 600).map(lambda n: b"\x2a" * n), st.just(b"\0\0")
    ),
    max_size=6,
).map(b"".join)
U32 = st.integers(0, 2**32 - 1)


@pytest.mark.parametrize("golden", GOLDEN, ids=lambda g: g.name)
def test_golden_frames(core: Core, golden: Golden) -> None:
    payload, wire = bytes.fromhex(golden.payload), bytes.fromhex(golden.wire)
    assert core.encode(golden.type, golden.counter, payload) == wire
    assert protocol.encode(golden.type, golden.counter, payload) == wire
    assert wire.endswith(b"\0")
    assert core.decode(wire[:-1]) == (golden.type, golden.counter, payload)
    frame = protocol.decode(wire[:-1])
    assert (frame.type, frame.counter, frame.payload) == (golden.type, golden.counter, payload)


# Examples of the original paper, and runs of critical length.
@pytest.mark.parametrize(
    ("data", "stuffed"),
    [
        ("", "01"),
        ("00", "0101"),
        ("0000", "010101"),
        ("11220033", "0311220233"),
        ("11000000", "0211010101"),
        ("01" * 254, "ff" + "01" * 254 + "01"),
        ("01" * 255, "ff" + "01" * 254 + "0201"),
        ("00" + "01" * 254, "01ff" + "01" * 254 + "01"),
        ("01" * 254 + "00", "ff" + "01" * 254 + "0101"),
    ],
)
def test_stuffing_of_known_examples(core: Core, data: str, stuffed: str) -> None:
    assert core.stuff(bytes.fromhex(data)).hex() == stuffed
    assert core.unstuff(bytes.fromhex(stuffed)) == bytes.fromhex(data)


@given(data=RUNS)
def test_stuffing_equals_pythons_and_is_reversible(core: Core, data: bytes) -> None:
    stuffed = core.stuff(data)
    assert stuffed == protocol.stuff(data)
    assert 0 not in stuffed
    assert core.unstuff(stuffed) == data


@given(data=RUNS)
def test_unstuffing_equals_pythons_for_any_bytes(core: Core, data: bytes) -> None:
    try:
        expected: bytes | None = protocol.unstuff(data)
    except protocol.FrameError:
        expected = None
    assert core.unstuff(data) == expected


@given(kind=st.integers(0, 255), counter=U32, payload=RUNS)
def test_frames_equal_pythons_and_are_reversible(
    core: Core, kind: int, counter: int, payload: bytes
) -> None:
    wire = core.encode(kind, counter, payload)
    assert wire == protocol.encode(kind, counter, payload)
    assert core.decode(wire[:-1]) == (kind, counter, payload)


@given(data=st.data())
def test_flipped_bit_is_refused(core: Core, data: st.DataObject) -> None:
    wire = bytearray(core.encode(protocol.FrameType.MARK, 5, data.draw(st.binary(max_size=200))))
    place = data.draw(st.integers(0, len(wire) - 2))
    wire[place] ^= 1 << data.draw(st.integers(0, 7))
    assert core.decode(bytes(wire[:-1])) is None


@pytest.mark.parametrize("n", range(9))
def test_too_short_frame_is_refused(core: Core, n: int) -> None:
    assert core.decode(core.stuff(b"\x81" * n)) is None


@given(first=U32, overflow=U32, n=st.integers(1, 5))
def test_payloads_equal_pythons(core: Core, first: int, overflow: int, n: int) -> None:
    data = np.arange(16 * n, dtype=np.int16).reshape(n, 16)
    head = core.samples_head(first, overflow, n)
    assert head + data.tobytes() == protocol.samples_payload(first, overflow, data)
    assert core.stopped_payload(first, overflow) == protocol.stopped_payload(first, overflow)
    assert core.descriptor_payload(first, "{ü}".encode()) == protocol.descriptor_payload(
        first, "{ü}"
    )
    assert core.marker_payload(first, "rôle".encode()) == protocol.marker_payload(first, "rôle")
    assert core.refused_payload(b"no") == bytes([protocol.VERSION]) + b"no"


@given(
    sample=U32,
    decided=U32,
    finger=st.sampled_from(Finger),
    flags=st.integers(0, 3),
    reason=st.sampled_from(Reason),
    ns=U32,
)
def test_payloads_of_predictions_equal_pythons(
    core: Core, sample: int, decided: int, finger: Finger, flags: int, reason: int, ns: int
) -> None:
    number, first = list(Finger).index(finger), bool(flags & 1)
    payload = core.contact_payload(sample, decided, number, first)
    contact = DeviceContact(finger, sample, decided, first, 3)
    assert read_contact(payload, 3) == contact
    assert read_contact(payload, 3, withdrawn=True) == replace(contact, withdrawn=True)
    estimate = DeviceEstimate(
        finger, sample, 59, decided, 41.5, 30.25, 52.75, first, flags & 2 > 0, ns * 1e-9, 3, reason
    )
    flags |= reason << 4
    payload = core.estimate_payload(sample, decided, 59, number, flags, 41.5, 30.25, 52.75, ns)
    assert read_estimate(payload, 3) == estimate


@given(skipped=U32, unheard=U32)
def test_payloads_of_late_counts_equal_pythons(core: Core, skipped: int, unheard: int) -> None:
    assert protocol.read_late(core.late_payload(skipped, unheard)) == (skipped, unheard)


@pytest.mark.parametrize("read", [read_contact, read_estimate])
def test_damaged_predictions_are_refused(read: Callable[[bytes, int], object]) -> None:
    for payload in (b"", bytes(9), bytes(27), b"\xff" * 10, b"\xff" * 28):
        with pytest.raises(protocol.FrameError):
            read(payload, 0)


COUNTS = st.one_of(st.integers(0, ADC_COUNTS - 1), st.integers(0, 0xFFFF))
RAILS = st.sampled_from([0, ADC_COUNTS - 1])
SHAPES = st.tuples(st.integers(1, 120), st.just(6))


def with_strips(scans: NDArray[np.uint16]) -> NDArray[np.uint16]:
    scans[:, 4:] &= 1
    return scans


@given(
    scans=st.one_of(
        arrays(np.uint16, SHAPES, elements=COUNTS), arrays(np.uint16, SHAPES, elements=RAILS)
    )
)
@settings(max_examples=60)
def test_filters_equal_the_twins_bit_for_bit(core: Core, scans: NDArray[np.uint16]) -> None:
    scans = with_strips(scans)
    np.testing.assert_array_equal(core.filtered(scans), DeviceFilter().update(scans))


def test_scan_goes_row_by_row(core: Core) -> None:
    expected = [(i % 6 // 2, i % 6 % 2) for i in range(25)]
    assert core.taxels(25) == expected


@pytest.mark.parametrize("clock", [600_000_000, 25_000_000, 24_000_000, 4936, 5000])
def test_samples_of_one_second_last_one_second_to_the_tick(core: Core, clock: int) -> None:
    rate = int(FINGERTIP_RATE)
    periods = core.periods(clock, rate, 3 * rate)
    assert set(periods) <= {clock // rate, clock // rate + 1}
    ends = [0, *itertools.accumulate(periods)]
    assert {b - a for a, b in zip(ends, ends[rate:], strict=False)} == {clock}


@given(clock=st.integers(1, 2**32 - 1), rate=st.integers(1, 2**31 - 1))
def test_no_sample_is_off_by_a_tick(core: Core, clock: int, rate: int) -> None:
    if clock < rate:
        clock, rate = rate, clock
    ends = itertools.accumulate(core.periods(clock, rate, 50))
    assert all(end == (n + 1) * clock // rate for n, end in enumerate(ends))


def test_firmware_and_twin_sample_at_the_rate_of_the_layout() -> None:
    sources = {
        "firmware/core/fc_pace.h": "FC_RATE_HZ",
        "src/firstcontact/twin/c/fingertips.c": "RATE",
    }
    for path, name in sources.items():
        text = (Path(__file__).parents[2] / path).read_text(encoding="utf-8")
        found = re.search(rf"\b{name} = ([\d.]+)", text)
        assert float(found[1]) == FINGERTIP_RATE
