"""Tests of replay: all content comes at its samples, for all block sizes."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numbered import DESCRIPTOR, check, numbered

from firstcontact.core import Block, Calibration, Finger, InputError, Label, VibrationCalibration
from firstcontact.device import Arrival, LinkNews, ReplaySource, open_source
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


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("replay") / "recording.mcap"
    header = Header(
        DESCRIPTOR.layout, "synthetic", sensor="a sensor", hand="a hand", firmware="a firmware",
        calibration=CALIBRATION,
    )  # fmt: skip
    with RecordingWriter(path, header) as writer:
        for epoch, first, end in STRETCHES:
            writer.write(Block(numbered(first, end - first), first, epoch))
        for marker in MARKERS:
            writer.marker(marker)
        for mark in PINCHES:
            writer.mark(mark)
    return path


def play(source: ReplaySource) -> list[Arrival]:
    arrivals = []
    with source:
        while not source.ended:
            arrivals += source.read(1.0)
        assert source.read(1.0) == []
    return arrivals


def stretches(arrivals: list[Arrival]) -> list[tuple[int, int, int]]:
    out: list[tuple[int, int, int]] = []
    for b in (a.block for a in arrivals):
        if out and out[-1][::2] == (b.epoch, b.first_sample):
            out[-1] = (b.epoch, out[-1][1], b.end)
        else:
            out.append((b.epoch, b.first_sample, b.end))
    return out


@given(block=st.integers(1, 3000))
def test_replay_keeps_all_positions(recording: Path, block: int) -> None:
    source = ReplaySource(recording, math.inf, block)
    arrivals = play(source)
    assert check(a.block for a in arrivals) == 2307
    assert tuple(stretches(arrivals)) == STRETCHES
    assert all(len(a.block.data) <= block for a in arrivals)
    assert [m for a in arrivals for m in a.markers] == list(MARKERS)
    assert [p for a in arrivals for p in a.pinches] == list(PINCHES)
    for arrival in arrivals[:-1]:
        end = (arrival.block.epoch, arrival.block.end)
        assert all((m.epoch, m.sample) < end for m in arrival.markers)
        assert all((p.epoch, p.end) <= end for p in arrival.pinches)
    health = source.health
    assert (health.samples, health.lost_samples, health.epoch) == (2307, 200, 1)
    assert not health.connected
    health_before = replace(health, connected=True, ended=False)
    assert LinkNews(health_before).lines(health) == ["link: end of the recording"]


def test_descriptor_is_that_of_the_recording(recording: Path) -> None:
    source = ReplaySource(recording)
    assert source.name == str(recording)
    assert source.descriptor.layout == DESCRIPTOR.layout
    assert (source.descriptor.sensor, source.descriptor.hand) == ("a sensor", "a hand")
    assert (source.descriptor.firmware, source.descriptor.source) == ("a firmware", "synthetic")
    assert source.calibration == CALIBRATION


def test_paced_blocks_have_their_due_times(
    recording: Path,
) -> None:
    speed = 5.0
    source = ReplaySource(recording, speed)
    arrivals = play(source)
    assert tuple(stretches(arrivals)) == STRETCHES
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


@pytest.mark.parametrize("speed", [0.0, -1.0, math.nan, -math.inf])
def test_invalid_speeds_are_refused(recording: Path, speed: float) -> None:
    with pytest.raises(InputError, match="--speed"):
        open_source(str(recording), speed=speed)


def test_invalid_recordings_and_block_sizes_are_refused(recording: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="block"):
        ReplaySource(recording, 1.0, -5)
    with pytest.raises(InputError, match=r"no\.mcap"):
        open_source(str(tmp_path / "no.mcap"))
    empty = tmp_path / "empty.mcap"
    RecordingWriter(empty, Header(DESCRIPTOR.layout)).close()
    with pytest.raises(InputError, match="samples"):
        open_source(str(empty))
