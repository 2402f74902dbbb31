"""Tests of replay, directly and on a pseudo terminal: all content comes at its samples."""

import math
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numbered import DESCRIPTOR, check, numbered, stretches
from scripted_device import collect

from firstcontact.core import Block, Calibration, Finger, InputError, Label, VibrationCalibration
from firstcontact.device import Arrival, open_source
from firstcontact.device.ports import PseudoTerminal
from firstcontact.device.replay import ReplayDevice, ReplaySource
from firstcontact.device.serial_source import SerialSource
from firstcontact.device.source import LinkNews
from firstcontact.recording import Header, Marker, PinchMark, RecordingWriter

CALIBRATION = Calibration((VibrationCalibration(Finger.INDEX, 0.005),))
MARKERS = (Marker(0, "first"), Marker(999, "last of a stretch"), Marker(1100, "in the gap"),
           Marker(3, "again", 1), Marker(500, "after the end", 1))  # fmt: skip
PINCHES = (
    PinchMark(0, 100, 400, 0, Label("block 20", 20.0)),
    PinchMark(1, 900, 1300, 0),
    PinchMark(2, 0, 500, 1),
)
#: Epoch, first sample, end: a gap of 200, and a restart.
STRETCHES = ((0, 0, 1000), (0, 1200, 2007), (1, 0, 500))


def write(
    path: Path,
    header: Header,
    stretches: Sequence[tuple[int, int, int]],
    markers: Sequence[Marker],
    pinches: Sequence[PinchMark] = (),
) -> Path:
    """Write a recording of numbered samples."""
    with RecordingWriter(path, header) as writer:
        for epoch, first, end in stretches:
            writer.write(Block(numbered(first, end - first), first, epoch))
        for marker in markers:
            writer.marker(marker)
        for mark in pinches:
            writer.mark(mark)
    return path


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("replay") / "recording.mcap"
    header = Header(
        DESCRIPTOR.layout, "synthetic", sensor="a sensor", hand="a hand", firmware="a firmware",
        calibration=CALIBRATION,
    )  # fmt: skip
    return write(path, header, STRETCHES, MARKERS, PINCHES)


def play(source: ReplaySource) -> list[Arrival]:
    arrivals = []
    with source:
        while not source.ended:
            arrivals += source.read(1.0)
        assert source.read(1.0) == []
    return arrivals


@given(block=st.integers(1, 3000))
def test_replay_keeps_all_positions(recording: Path, block: int) -> None:
    source = ReplaySource(recording, math.inf, block)
    arrivals = play(source)
    assert check(a.block for a in arrivals) == 2307
    assert tuple(stretches(a.block for a in arrivals)) == STRETCHES
    assert all(len(a.block.data) <= block for a in arrivals)
    assert [m for a in arrivals for m in a.markers] == list(MARKERS)
    assert [p for a in arrivals for p in a.pinches] == list(PINCHES)
    for arrival in arrivals[:-1]:
        end = (arrival.block.epoch, arrival.block.end)
        assert all((m.epoch, m.sample) < end for m in arrival.markers)
        assert all((p.epoch, p.first_sample) < end for p in arrival.pinches)
    health = source.health
    assert (health.samples, health.lost_samples, health.epoch) == (2307, 200, 1)
    assert not health.connected
    health_before = replace(health, connected=True, ended=False)
    assert LinkNews(health_before).lines(health) == ["link: end of the recording"]


def test_paced_blocks_have_their_due_times(recording: Path) -> None:
    speed = 5.0
    source = ReplaySource(recording, speed)
    arrivals = play(source)
    assert tuple(stretches(a.block for a in arrivals)) == STRETCHES
    sample_counts = np.cumsum([len(a.block.data) for a in arrivals])
    hosts = np.array([a.host for a in arrivals])
    due = sample_counts / (speed * DESCRIPTOR.layout.rate)
    np.testing.assert_allclose(hosts - hosts[0], due - due[0], atol=1e-6)


def test_a_replay_begins_at_the_first_read(recording: Path) -> None:
    with ReplaySource(recording) as source:
        opened = time.monotonic()
        while (begun := time.monotonic()) < opened + 0.05:
            pass  # a model that is loaded, for example
        (first, *_) = source.read(5.0)
    assert first.host >= begun


def test_invalid_recordings_and_block_sizes_are_refused(recording: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="block"):
        ReplaySource(recording, 1.0, -5)
    with pytest.raises(InputError, match=r"no\.mcap"):
        open_source(str(tmp_path / "no.mcap"))
    empty = tmp_path / "empty.mcap"
    RecordingWriter(empty, Header(DESCRIPTOR.layout)).close()
    with pytest.raises(InputError, match="samples"):
        open_source(str(empty))


#: Of the recording on a terminal: epoch, first sample, end; none of a whole number of frames.
SENT = ((0, 7, 1004), (0, 1203, 2006), (1, 0, 498), (2, 2**32 - 100, 2**32 + 903))
SAMPLES = sum(end - first for _, first, end in SENT)
SENT_MARKERS = (Marker(1500, "a word", 0), Marker(100, "another", 1))


@pytest.fixture
def sent(tmp_path: Path) -> Path:
    header = Header(DESCRIPTOR.layout, "synthetic", hand="a hand")
    return write(tmp_path / "recording.mcap", header, SENT, SENT_MARKERS)


@contextmanager
def plugged(port: Path) -> Iterator[PseudoTerminal]:
    terminal = PseudoTerminal(port)
    try:
        yield terminal
    finally:
        terminal.unplug()


@contextmanager
def playing(sent: Path, port: Path, speed: float = math.inf) -> Iterator[None]:
    with plugged(port) as terminal:
        device = ReplayDevice(sent, terminal, speed)
        stop = threading.Event()
        thread = threading.Thread(target=device.run, args=(stop.is_set,))
        thread.start()
        try:
            yield
        finally:
            stop.set()
            thread.join()


@pytest.mark.parametrize("speed", [math.inf, 10.0])
def test_replay_keeps_samples_gaps_epochs_and_markers(
    sent: Path, tmp_path: Path, speed: float
) -> None:
    with playing(sent, tmp_path / "port", speed):
        with SerialSource(str(tmp_path / "port")) as source:
            assert source.descriptor.hand == "a hand"
            # A stop would pause the replay, with the last samples not sent.
            arrivals = collect(source, lambda n: n >= SAMPLES)
        arrivals += source.read(0)
    assert check(a.block for a in arrivals) == SAMPLES
    blocks = [a.block for a in arrivals]
    for epoch in range(3):
        stretches = [s for s in SENT if s[0] == epoch]
        epoch_blocks = [b for b in blocks if b.epoch == epoch]
        assert (epoch_blocks[0].first_sample, epoch_blocks[-1].end) == (
            stretches[0][1],
            stretches[-1][2],
        )
    assert [m for a in arrivals for m in a.markers] == list(SENT_MARKERS)
    health = source.health
    assert (health.samples, health.lost_samples, health.reconnects) == (SAMPLES, 199, 2)
    assert (health.bad_frames, health.lost_frames, health.overflow_samples) == (0, 0, 0)


def test_replay_pauses_on_stop_and_restarts_after_the_end(sent: Path, tmp_path: Path) -> None:
    port = str(tmp_path / "port")
    with playing(sent, tmp_path / "port"):
        blocks: list[Block] = []
        while sum(len(b.data) for b in blocks) < SAMPLES:
            with SerialSource(port) as source:
                first_arrivals = source.read(60.0)
            blocks += [a.block for a in (*first_arrivals, *source.read(0))]
            assert source.health.bad_frames == 0
        with SerialSource(port) as source:
            restarted = collect(source, lambda n: n >= 100)
    assert restarted[0].block.first_sample == 7
    numbers = np.concatenate([np.arange(first, end) for _, first, end in SENT])
    # A host that comes after 2^32 samples cannot know of those before.
    block_numbers = np.concatenate([np.arange(b.first_sample, b.end) for b in blocks])
    np.testing.assert_array_equal(block_numbers % 2**32, numbers % 2**32)
    for block in blocks:
        np.testing.assert_array_equal(block.data, numbered(block.first_sample, len(block.data)))


def test_recording_of_floats_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "floats.mcap"
    with RecordingWriter(path, Header(DESCRIPTOR.layout, dtype="float32")) as writer:
        writer.write(Block(np.zeros((10, 16), np.float32)))
    with plugged(tmp_path / "port") as terminal, pytest.raises(InputError, match="float32"):
        ReplayDevice(path, terminal)


@pytest.mark.parametrize(
    ("gap", "speed", "paced"),
    [(0, 1.0, True), (0, 4.0, False), (0, math.inf, False), (9, 1.0, False)],
)
def test_descriptor_states_real_time(gap: int, speed: float, paced: bool, tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with RecordingWriter(path, Header(DESCRIPTOR.layout, "synthetic")) as writer:
        writer.write(Block(numbered(0, 50), 0))
        writer.write(Block(numbered(50 + gap, 50), 50 + gap))
        writer.write(Block(numbered(0, 50), 0, 1))  # an epoch of its own is no gap
    with plugged(tmp_path / "port") as terminal:
        assert ReplayDevice(path, terminal, speed).descriptor.paced is paced
