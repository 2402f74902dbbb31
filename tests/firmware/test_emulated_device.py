"""Firmware on an emulated Cortex-M7 whose UART is a pseudo terminal."""

import re
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from device_process import random_scans, running
from numpy.typing import NDArray
from serial_host import Host, assert_gaps_are_overflow

from firstcontact.device.protocol import FrameType
from firstcontact.twin.sensor import DeviceFilter


@contextmanager
def emulated(image: Path, *arguments: str, more: Sequence[str] = ()) -> Iterator[str]:
    """Run the firmware with more options for the emulator. Yield the path of its UART."""
    semihosting = ",".join(["enable=on", "target=native", *(f"arg={a}" for a in arguments)])
    command = ["qemu-system-arm", "-M", "mps2-an500", "-display", "none", "-monitor", "none"]
    command += ["-serial", "pty", "-semihosting-config", semihosting, "-kernel", str(image)]
    command += more
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    ) as process:
        try:
            output = ""
            while not (match := re.search(r"redirected to (\S+)", output)):
                line = process.stdout.readline().decode()
                assert line, f"the emulator ended: {output}"
                output += line
            yield match[1]
            assert process.poll() is None, process.stdout.read().decode()
        finally:
            process.terminate()


def pattern(n: int) -> NDArray[np.uint16]:
    """Return the firmware's test pattern, shape (n, 6). It contains the sample's number."""
    i = np.arange(n)
    columns = [i & 1023, i >> 10 & 1023, 7 * i & 1023, 1023 - (i & 1023), i & 1, i >> 1 & 1]
    return np.stack(columns, axis=1).astype(np.uint16)


def test_all_frames_arrive(image: Path) -> None:
    with emulated(image, "free") as path, Host(path) as host:
        host.hello()
        host.send(FrameType.START)
        host.until(lambda: host.received >= 10_000)
        marked, text = host.mark("über den Draht")
        next_sample, overflow = host.stop()
        assert text == "über den Draht"
        assert 10_000 <= marked <= next_sample == host.received
        assert overflow == 0
        host.assert_all_samples()
        np.testing.assert_array_equal(host.data(), DeviceFilter().update(pattern(next_sample)))


def test_samples_equal_the_native_programs_and_pythons(
    image: Path, program: Path, tmp_path: Path
) -> None:
    scans = random_scans(6003, 9)
    scans.tofile(tmp_path / "random.scans")
    data = []
    with running(program, "--scans", str(tmp_path / "random.scans"), "--speed", "20") as device:
        data.append(all_samples(device.path, len(scans)))
    with emulated(image, "free", str(tmp_path / "random.scans")) as path:
        data.append(all_samples(path, len(scans)))
    np.testing.assert_array_equal(data[0], DeviceFilter().update(scans))
    np.testing.assert_array_equal(data[1], data[0])


def all_samples(path: str, n: int) -> NDArray[np.int16]:
    with Host(path) as host:
        host.send(FrameType.START)
        host.until(lambda: host.received >= n // 5 * 5)
        host.until(lambda: host.mark()[0] == n)
        assert host.stop() == (n, 0)
        host.assert_all_samples()
        return host.data()


def test_samples_of_the_timer_interrupt_arrive_or_are_counted(image: Path) -> None:
    with emulated(image, "timer") as path, Host(path) as host:
        host.hello()
        host.send(FrameType.START)
        host.until(lambda: host.received >= 2000)
        next_sample, overflow = host.stop()
        host.assert_all_frames()
        assert host.received + overflow == next_sample
        assert_gaps_are_overflow(host.samples())
        received = [s.first_sample + k for s in host.samples() for k in range(len(s.data))]
        expected = DeviceFilter().update(pattern(next_sample))[received]
        np.testing.assert_array_equal(host.data(), expected)
