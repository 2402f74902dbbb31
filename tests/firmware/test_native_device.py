"""Firmware core as a program on a pseudo terminal."""

import subprocess
from pathlib import Path

import numpy as np
import pytest
from device_process import random_scans, running
from serial_host import Host, assert_gaps_are_overflow

from firstcontact.core import fingertip_layout
from firstcontact.device import Descriptor, protocol
from firstcontact.device.protocol import FrameType
from firstcontact.twin import TwinStream
from firstcontact.twin.sensor import DeviceFilter

#: Most scans in a pipe of 64 KiB and the program's buffer.
WAITING = 65536 // 12 + 1 + 512


def test_all_frames_arrive_at_full_rate_with_the_twins_bits(program: Path, tmp_path: Path) -> None:
    scans = TwinStream(seed=4).read(3 * 4936)
    scans.tofile(tmp_path / "twin.scans")
    # The ring holds all samples: a host that is stopped for a while must lose none.
    options = ("--scans", str(tmp_path / "twin.scans"), "--ring", str(len(scans)))
    with running(program, *options) as device, Host(device.path) as host:
        host.hello()
        host.send(FrameType.START)
        host.until(lambda: host.received >= len(scans) // 5 * 5)
        host.until(lambda: host.mark()[0] == len(scans))
        assert host.stop() == (len(scans), 0)
        host.assert_all_samples()
        np.testing.assert_array_equal(host.data(), DeviceFilter().update(scans))


def test_descriptor_has_the_layout_of_the_fingertips(strict_program: Path) -> None:
    with running(strict_program, "--boot", "4023456789") as device, Host(device.path) as host:
        version, boot, text = protocol.read_descriptor(host.hello().payload)
    descriptor = Descriptor.from_text(text)
    assert (version, boot) == (protocol.VERSION, 4023456789)
    assert descriptor.layout == fingertip_layout()
    assert descriptor.source == "twin"
    assert descriptor.firmware.endswith("(native)")


def test_boot_numbers_differ(strict_program: Path) -> None:
    boots = set()
    for _ in range(3):
        with running(strict_program) as device, Host(device.path) as host:
            boots.add(protocol.read_descriptor(host.hello().payload)[1])
    assert len(boots) == 3


def test_stop_sends_the_remaining_samples_first(strict_program: Path) -> None:
    scans = random_scans(13, 2)
    with running(strict_program) as device, Host(device.path) as host:
        host.send(FrameType.START)
        device.feed(scans)
        host.until(lambda: host.mark()[0] == len(scans))
        assert host.stop() == (13, 0)
        assert [len(s.data) for s in host.samples()] == [5, 5, 3]
        assert host.frames[-1].type == FrameType.STOPPED
        host.assert_all_samples()
        np.testing.assert_array_equal(host.data(), DeviceFilter().update(scans))


def test_counter_and_filters_run_while_not_streaming(strict_program: Path) -> None:
    scans = random_scans(90, 3)
    with running(strict_program) as device, Host(device.path) as host:
        host.send(FrameType.START)
        device.feed(scans[:20])
        host.until(lambda: host.received == 20)
        assert host.stop() == (20, 0)
        device.feed(scans[20:53])
        host.until(lambda: host.mark()[0] == 53)
        host.send(FrameType.START)
        device.feed(scans[53:])
        host.until(lambda: host.mark()[0] == 90)
        assert host.stop() == (90, 0)
        host.assert_all_frames()
        numbers = [s.first_sample + k for s in host.samples() for k in range(len(s.data))]
        assert numbers == [*range(20), *range(53, 90)]
        np.testing.assert_array_equal(host.data(), DeviceFilter().update(scans)[numbers])


def test_marks_return_with_their_text_and_the_next_samples_number(strict_program: Path) -> None:
    with running(strict_program) as device, Host(device.path) as host:
        assert host.mark("before") == (0, "before")
        host.send(FrameType.START)
        device.feed(random_scans(10, 4))
        host.until(lambda: host.received == 10)
        assert host.mark("après\r\n") == (10, "après\r\n")
        longest = "é" * (protocol.MARKER_BYTES // 2)
        assert host.mark(longest) == (10, longest)
        host.send(FrameType.MARK, b"x" * (protocol.MARKER_BYTES + 1))
        assert host.mark("after one that is too long") == (10, "after one that is too long")
        host.assert_all_frames()


def test_other_version_is_refused_and_the_right_one_then_accepted(strict_program: Path) -> None:
    with running(strict_program) as device, Host(device.path) as host:
        host.send(FrameType.HELLO, bytes([protocol.VERSION + 1]))
        refused = host.answer(FrameType.REFUSED).payload
        assert refused[0] == protocol.VERSION
        assert f"version {protocol.VERSION} " in refused[1:].decode()
        host.hello()
        host.assert_all_frames()


def test_unknown_bytes_are_ignored(strict_program: Path) -> None:
    rng = np.random.default_rng(5)
    with running(strict_program) as device, Host(device.path) as host:
        hello = protocol.encode(FrameType.HELLO, 0, bytes([protocol.VERSION]))
        for garbage in (
            rng.bytes(5000),  # random bytes, zeros included
            b"\x2a" * 5000 + b"\0",  # longer than any frame
            b"\0\0\0",
            hello[:-3] + b"\0",  # cut short
            bytes([hello[0], hello[1] ^ 4]) + hello[2:],  # a flipped bit
            protocol.encode(0x85, 0, b"of a later version"),
            protocol.encode(FrameType.HELLO, 0),  # without a version
            protocol.encode(FrameType.SAMPLES, 0, b"our own"),
        ):
            host.port.write(garbage)
        host.port.write(b"\0")
        host.hello()
        assert [f.type for f in host.frames] == [FrameType.DESCRIPTOR]
        host.assert_all_frames()


def test_host_that_stops_reading_does_not_stop_the_clock_and_losses_are_counted(
    strict_program: Path,
) -> None:
    scans = random_scans(30_000, 6)
    options = ("--speed", "50", "--ring", "64")
    with running(strict_program, *options) as device, Host(device.path) as host:
        host.send(FrameType.START)
        device.feed(scans)  # no host reads: this would block for ever if the device waited
        next_sample, overflow = host.stop()
        host.assert_all_frames()
        assert len(scans) - WAITING <= next_sample <= len(scans)
        assert overflow > 0
        assert host.received + overflow == next_sample
        assert_gaps_are_overflow(host.samples())
        received = [s.first_sample + k for s in host.samples() for k in range(len(s.data))]
        np.testing.assert_array_equal(host.data(), DeviceFilter().update(scans)[received])


def test_stream_continues_after_an_overflow(strict_program: Path) -> None:
    scans, more = np.split(random_scans(30_103, 10), [30_003])
    # 63 is not a multiple of 5, so that an incomplete frame precedes the gap.
    options = ("--speed", "50", "--ring", "63")
    with running(strict_program, *options) as device, Host(device.path) as host:
        host.send(FrameType.START)
        device.feed(scans)  # no host reads
        fed = len(scans)
        # The gap reaches the end of all scans that the device takes before the host reads.
        while not (host.select_frames(FrameType.SAMPLES) and host.samples()[-1].overflow > 0):
            device.feed(more)
            fed += len(more)
            host.receive()
        host.until(lambda: host.mark()[0] == fed)
        end, overflow = host.stop()
        assert host.received + overflow == end
        assert_gaps_are_overflow(host.samples())


def test_host_can_reconnect(strict_program: Path) -> None:
    with running(strict_program) as device:
        with Host(device.path) as host:
            host.send(FrameType.START)
            device.feed(random_scans(40, 7))
            host.until(lambda: host.received >= 10)
        with Host(device.path) as host:
            host.hello()
            host.until(lambda: host.mark()[0] == 40)
            assert host.stop() == (40, 0)
            host.send(FrameType.START)
            device.feed(random_scans(40, 8))
            host.until(lambda: host.mark()[0] == 80)
            assert host.stop() == (80, 0)
            new = [s.first_sample for s in host.samples() if s.first_sample >= 40]
            assert new == list(range(40, 80, 5))


@pytest.mark.parametrize(
    "options",
    [
        [],
        ["--scans"],
        ["--scans", "none.scans"],
        ["--scans", "-", "--speed", "0"],
        ["--scans", "-", "--ring", "x"],
        ["--scans", "-", "--colour", "red"],
    ],
)
def test_wrong_options_are_refused(
    strict_program: Path, options: list[str], tmp_path: Path
) -> None:
    process = subprocess.run(
        [strict_program, *options], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert process.returncode == 2
    assert "usage" in process.stderr or "none.scans" in process.stderr
