"""Teensy's sketch as a program of this machine, on a simulated board."""

import subprocess
import threading
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from device_process import Running, random_scans, running
from hand import Predictions, chain_events, of_chain, of_device
from numpy.typing import NDArray
from serial_host import Host

from firstcontact.core import InputError
from firstcontact.device import Descriptor, protocol
from firstcontact.device.assembler import Assembler
from firstcontact.device.flashing import CHUNK, flash_model
from firstcontact.device.protocol import FrameType
from firstcontact.export.hand_image import HandImage
from firstcontact.twin import TwinStream
from firstcontact.twin.sensor import DeviceFilter

Scans = NDArray[np.uint16]
Images = tuple[HandImage, HandImage]
SAMPLES = 12 * 4936
#: Bytes of a slot's head, of a page and of a sector of the flash.
HEAD, PAGE, SECTOR = 16, 256, 4096


@pytest.fixture(scope="module")
def scans() -> Scans:
    return TwinStream(seed=4).read(SAMPLES)


@dataclass(frozen=True)
class Board:
    """Simulated board with the sketch and a flash file."""

    sketch: Path
    flash: Path

    def running(self, *options: str) -> AbstractContextManager[Running]:
        return running(self.sketch, "--flash", str(self.flash), *options)

    @contextmanager
    def started(self, *options: str) -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
        """Start the board, which may stop early. Yield its port and its process."""
        command = [self.sketch, "--scans", "-", "--flash", self.flash, *options]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
            yield process.stdout.readline().decode().strip(), process
            process.kill()

    def put(self, *images: HandImage, options: Sequence[str] = ()) -> None:
        with self.running(*options) as device:
            for image in images:
                assert flash_model(device.path, image.data) == image.digest

    @property
    def model(self) -> str | None:
        """Digest of the active model after the next start."""
        with self.running() as device, Host(device.path) as host:
            text = protocol.read_descriptor(host.hello().payload)[2]
        predictor = Descriptor.from_text(text).predictor
        return None if predictor is None else predictor.model


@pytest.fixture
def board(sketch: Path, tmp_path: Path) -> Board:
    return Board(sketch, tmp_path / "flash")


@contextmanager
def feeding(device: Running, scans: Scans) -> Iterator[None]:
    """Feed the scans in a thread, because the pipe blocks until the device reads."""
    thread = threading.Thread(target=device.feed, args=(scans,))
    thread.start()
    yield
    thread.join()


def streamed(device: Running, scans: Scans) -> list[protocol.Frame]:
    """Return the frames of a stream with these scans."""
    with Host(device.path) as host:
        host.hello()
        host.send(FrameType.START)
        assert host.mark()[0] == 0
        with feeding(device, scans):
            host.until(lambda: host.received >= len(scans) // 5 * 5)
        host.assert_all_samples()
        return host.frames


def predictions(frames: list[protocol.Frame]) -> Predictions:
    return of_device(Assembler().take(frames).predictions)


def final_moments(answers: Predictions) -> dict[int, int]:
    """Return the moment of the last estimate before the second contact, by first contact."""
    newest = {}
    for (_, first, _, _, _), (_, second, _, later, _) in pairwise(answers.contacts):
        if not later:
            moments = [n for c, n in answers.estimates if c == first and n <= second - first]
            newest[first] = max(moments, default=0)
    return newest


def expected_lines(answers: Predictions) -> list[str]:
    """Return the lines of the example in own_hand.cpp: contacts first, then estimates."""
    contacts = [
        f"W {channel}" if is_withdrawn else f"C {channel} {first:d}"
        for channel, _, _, first, is_withdrawn in answers.contacts
    ]
    estimates = [
        f"{'S' if strange else 'A'} {value:.1f} {low:.1f} {high:.1f}"
        for (_, n), (value, low, high, strange, _) in answers.estimates.items()
        if n > 0
    ]
    return contacts + estimates


def lines(path: Path) -> list[str]:
    """Return the lines of Serial1, contacts first."""
    written = path.read_text(encoding="ascii").splitlines()
    return sorted(written, key=lambda line: line[0] not in "CW")


def test_sketch_without_a_model_streams(board: Board) -> None:
    scans = random_scans(1003, 1)
    assert board.model is None
    with board.running() as device, Host(device.path) as host:
        host.send(FrameType.START)
        assert host.mark()[0] == 0
        device.feed(scans)
        host.until(lambda: host.mark()[0] == len(scans))
        assert host.stop() == (len(scans), 0)
        host.assert_all_samples()
        np.testing.assert_array_equal(host.data(), DeviceFilter().update(scans))


def test_model_survives_a_power_cut_and_predicts_as_live_does(
    board: Board, scans: Scans, images: Images, tmp_path: Path
) -> None:
    board.put(*images, images[0])
    with board.running("--serial1", str(tmp_path / "lines")) as device:
        device_says = predictions(streamed(device, scans))
    host = of_chain(chain_events(images[0], DeviceFilter().update(scans)))
    assert len(host.contacts) >= 5
    assert len(device_says.estimates) >= 25
    assert device_says == host
    assert lines(tmp_path / "lines") == expected_lines(device_says)


def test_sketch_predicts_without_a_computer(
    board: Board, scans: Scans, images: Images, tmp_path: Path
) -> None:
    board.put(images[0])
    (tmp_path / "scans").write_bytes(scans.astype("<u2").tobytes())
    alone = ["--flash", str(board.flash), "--scans", str(tmp_path / "scans"), "--unread", "yes"]
    alone += ["--serial1", str(tmp_path / "lines")]
    subprocess.run([board.sketch, *alone], check=True, timeout=60, capture_output=True)
    host = of_chain(chain_events(images[0], DeviceFilter().update(scans)))
    written = lines(tmp_path / "lines")
    assert [line for line in written if line[0] in "CW"] == expected_lines(
        Predictions(host.contacts, {})
    )
    assert len(written) > 30
    assert set(written) <= set(expected_lines(host))


def test_host_that_stops_reading_delays_nothing(
    board: Board, scans: Scans, images: Images, tmp_path: Path
) -> None:
    """Serial1 gets the same lines although the USB line is full."""
    board.put(images[0])
    with board.running("--serial1", str(tmp_path / "heard")) as device:
        streamed(device, scans)
    options = "--serial1", str(tmp_path / "unheard"), "--unread", "yes"
    with board.started(*options) as (path, process), Host(path) as host:
        host.hello()
        host.send(FrameType.START)
        assert host.mark()[0] == 0
        process.communicate(scans.astype("<u2").tobytes(), 60)
        assert process.returncode == 0
    assert lines(tmp_path / "unheard") == lines(tmp_path / "heard")


def operations(image: HandImage) -> int:
    """Return the number of erased sectors and written pages for a model, head included."""
    ends = np.append(np.arange(CHUNK, len(image.data), CHUNK), len(image.data)) + HEAD
    begins = np.append(HEAD, ends[:-1])
    pages = int(np.sum((ends - 1) // PAGE - begins // PAGE + 1))
    return -(-int(ends[-1]) // SECTOR) + pages + 1


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_power_cut_leaves_the_old_model(board: Board, images: Images, share: float) -> None:
    """The power fails while a sector is erased, during a write, or while the head is written."""
    old, new = images
    board.put(old)
    cut = 1 + round(share * (operations(new) - 1))
    with board.started("--cut", str(cut)) as (path, process):
        with pytest.raises(InputError, match="/"):
            flash_model(path, new.data)
        assert process.wait(60) == 3
    assert board.model == old.digest
    board.put(new, options=["--cut", str(operations(new) + 1)])
    assert board.model == new.digest


def test_samples_missed_during_a_write_keep_their_numbers(board: Board, images: Images) -> None:
    """The n-th scan belongs to the n-th period since the start, even if some were missed."""
    scans = random_scans(600_000, 2)
    with board.running() as device:
        with feeding(device, scans[:-1000]):
            flash_model(device.path, images[0].data)
            with Host(device.path) as host:
                host.hello()
                host.send(FrameType.START)
                host.until(lambda: host.received >= 1000)
                first = host.samples()[0].first_sample
                data = host.data()
                host.stop()
        assert first > 0.045 * 4936 * len(images[0].data) / SECTOR
        np.testing.assert_array_equal(data[:, -2:], scans[first : first + len(data), -2:])


def test_late_estimate_is_skipped_and_counted_and_no_sample_is_lost(
    board: Board, scans: Scans, images: Images
) -> None:
    """Here each reading of the clock takes 0.9 ms, and each estimate reads it twice."""
    board.put(images[0])
    with board.running("--busy-us", "900") as device:
        frames = streamed(device, scans)
    assembler = Assembler()
    device_says = of_device(assembler.take(frames).predictions)
    host = of_chain(chain_events(images[0], DeviceFilter().update(scans)))
    assert device_says.contacts == host.contacts
    assert len(device_says.estimates) > 10
    assert assembler.counts.late_answers > 10
    assert assembler.counts.unheard_samples == 0
    assert final_moments(device_says) == final_moments(host)
    for key, (*numbers, _) in device_says.estimates.items():
        assert numbers == list(host.estimates[key][:-1])


def test_very_late_estimates_miss_samples_that_are_still_sent(
    board: Board, scans: Scans, images: Images
) -> None:
    """Here an estimate takes 0.12 s, which is longer than the buffer of waiting samples."""
    board.put(images[0])
    with board.running("--busy-us", "60000") as device:
        frames = streamed(device, scans)
    assembler = Assembler()
    messages = assembler.take(frames).predictions
    assert len(messages) >= 4
    assert assembler.counts.unheard_samples > 100
