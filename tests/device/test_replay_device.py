"""Tests of a recording on a pseudo terminal, read by the serial source."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from numbered import DESCRIPTOR, check, numbered
from scripted_device import collect

from firstcontact.core import Block, InputError
from firstcontact.device import PseudoTerminal, ReplayDevice, SerialSource
from firstcontact.recording import Header, Marker, RecordingWriter

#: Epoch, first sample, end; none of a whole number of frames.
STRETCHES = ((0, 7, 1004), (0, 1203, 2006), (1, 0, 498), (2, 2**32 - 100, 2**32 + 903))
SAMPLES = sum(end - first for _, first, end in STRETCHES)
MARKERS = (Marker(1500, "a word", 0), Marker(100, "another", 1))


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    path = tmp_path / "recording.mcap"
    with RecordingWriter(path, Header(DESCRIPTOR.layout, "synthetic", hand="a hand")) as writer:
        for epoch, first, end in STRETCHES:
            writer.write(Block(numbered(first, end - first), first, epoch))
        for marker in MARKERS:
            writer.marker(marker)
    return path


@contextmanager
def playing(recording: Path, port: Path, speed: float = math.inf) -> Iterator[None]:
    terminal = PseudoTerminal(port)
    device = ReplayDevice(recording, terminal, speed)
    stop = threading.Event()
    thread = threading.Thread(target=device.run, args=(stop.is_set,))
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()
        terminal.unplug()


@pytest.mark.parametrize("speed", [math.inf, 10.0])
def test_replay_keeps_samples_gaps_epochs_and_markers(
    recording: Path, tmp_path: Path, speed: float
) -> None:
    with playing(recording, tmp_path / "port", speed):
        with SerialSource(str(tmp_path / "port")) as source:
            assert source.descriptor.hand == "a hand"
            # A stop would pause the replay, with the last samples not sent.
            arrivals = collect(source, lambda n: n >= SAMPLES)
        arrivals += source.read(0)
    assert check(a.block for a in arrivals) == SAMPLES
    blocks = [a.block for a in arrivals]
    for epoch in range(3):
        stretches = [s for s in STRETCHES if s[0] == epoch]
        epoch_blocks = [b for b in blocks if b.epoch == epoch]
        assert (epoch_blocks[0].first_sample, epoch_blocks[-1].end) == (
            stretches[0][1],
            stretches[-1][2],
        )
    assert [m for a in arrivals for m in a.markers] == list(MARKERS)
    health = source.health
    assert (health.samples, health.lost_samples, health.reconnects) == (SAMPLES, 199, 2)
    assert (health.bad_frames, health.lost_frames, health.overflow_samples) == (0, 0, 0)


def test_replay_pauses_on_stop_and_restarts_after_the_end(recording: Path, tmp_path: Path) -> None:
    port = str(tmp_path / "port")
    with playing(recording, tmp_path / "port"):
        blocks: list[Block] = []
        while sum(len(b.data) for b in blocks) < SAMPLES:
            with SerialSource(port) as source:
                first_arrivals = source.read(60.0)
            blocks += [a.block for a in (*first_arrivals, *source.read(0))]
            assert source.health.bad_frames == 0
        with SerialSource(port) as source:
            restarted = collect(source, lambda n: n >= 100)
    assert restarted[0].block.first_sample == 7
    numbers = np.concatenate([np.arange(first, end) for _, first, end in STRETCHES])
    # A host that comes after 2^32 samples cannot know of those before.
    block_numbers = np.concatenate([np.arange(b.first_sample, b.end) for b in blocks])
    np.testing.assert_array_equal(block_numbers % 2**32, numbers % 2**32)
    for block in blocks:
        np.testing.assert_array_equal(block.data, numbered(block.first_sample, len(block.data)))


def test_recording_of_floats_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "floats.mcap"
    with RecordingWriter(path, Header(DESCRIPTOR.layout, dtype="float32")) as writer:
        writer.write(Block(np.zeros((10, 16), np.float32)))
    terminal = PseudoTerminal(tmp_path / "port")
    try:
        with pytest.raises(InputError, match="float32"):
            ReplayDevice(path, terminal)
    finally:
        terminal.unplug()


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
    terminal = PseudoTerminal(tmp_path / "port")
    try:
        assert ReplayDevice(path, terminal, speed).descriptor.paced is paced
    finally:
        terminal.unplug()
