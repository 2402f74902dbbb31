"""Tests of a sound input through PortAudio and ALSA, with a simulated sound device."""

from pathlib import Path

import numpy as np
import pytest

from firstcontact.core import InputError
from firstcontact.device import Arrival, Source, open_source
from firstcontact.signal import CausalResampler, resample
from sound import local_sound

RATE = 48_000
#: Samples until the filter has forgotten how it began.
SETTLING = 60
#: Largest error of a gap's length, samples of the input: PortAudio's sampling times are as good.
GAP_ERROR = 8


def hum(samples: int) -> np.ndarray:
    """Return a signal that never repeats. Its frequencies are well below half of the lower rate."""
    t = np.arange(samples) / RATE
    return (8000 * np.sin(2 * np.pi * (200 * t + 60 * t**2))).astype(np.int16)


def until(source: Source, samples: int) -> list[Arrival]:
    arrivals: list[Arrival] = []
    while sum(len(a.block.data) for a in arrivals) < samples:
        arrivals += source.read(5.0)
    return arrivals


def agree(arrivals: list[Arrival], tape: np.ndarray) -> int:
    """Assert that blocks equal the tape at their sample numbers. Return how many were compared.

    On a busy machine samples are lost. After such a gap the filter restarts and needs time to
    settle.
    """
    played = resample(tape[:, None] / 32768.0, 48_000.0, 4936.0)[:, 0]
    slope = np.abs(np.gradient(played))
    looked, settled, end, gap_count = 0, 0, 0, 0
    for block in (a.block for a in arrivals):
        if block.first_sample != end:
            settled, gap_count = block.first_sample + SETTLING, gap_count + 1
        end = block.end
        if block.first_sample >= settled:
            on_tape = played[block.first_sample : block.end]
            shift = gap_count * GAP_ERROR * 4936 / RATE
            steepest = slope[block.first_sample - 2 : block.end + 2].max() if gap_count else 0.0
            np.testing.assert_allclose(block.data[:, 0], on_tape, atol=2e-5 + shift * steepest)
            looked += 1
    return looked


def gaps(arrivals: list[Arrival]) -> int:
    previous_ends = [0, *(a.block.end for a in arrivals)]
    return sum(end != a.block.first_sample for end, a in zip(previous_ends, arrivals, strict=False))


def test_samples_are_the_played_ones_with_their_numbers(tmp_path: Path) -> None:
    tape = hum(6 * RATE)
    with local_sound(tmp_path, tape), open_source("audio:disc") as source:
        arrivals = until(source, 4000)
        assert source.descriptor.layout.rate == 4936.0
        assert source.descriptor.delay == CausalResampler(48_000.0, 4936.0).delay <= 0.0005
    assert agree(arrivals, tape) > 10


def test_overflow_is_a_gap_of_its_length(tmp_path: Path) -> None:
    overflow = 4800
    tape = hum(6 * RATE)
    with (
        local_sound(tmp_path, tape, lose_at=RATE // 2, lose=overflow),
        open_source("audio:disc") as source,
    ):
        arrivals = until(source, 4936)
        source.close()  # no overflow is counted between the reading and the counts
        arrivals += source.read(0.0)
        health = source.health
    # What was in the buffer is lost, too.
    assert health.overflow_samples >= overflow * 4936 // RATE
    # What lies before a gap and needs samples of the gap does not come either. Each end of a gap
    # falls between two samples, and the overflow is rounded once.
    edges = CausalResampler(48_000.0, 4936.0).delay * 4936.0 + 1
    assert abs(health.lost_samples - health.overflow_samples) <= edges * gaps(arrivals) + 1
    assert gaps(arrivals) >= 1
    assert agree(arrivals, tape) > 10


def test_unplugged_input_ends_with_an_input_error(tmp_path: Path) -> None:
    tape = hum(RATE // 2)
    with local_sound(tmp_path, tape, waits=1), open_source("audio:disc") as source:
        with pytest.raises(InputError, match="audio:disc"):
            until(source, 10 * RATE)
        assert source.ended
        assert not source.health.connected
        with pytest.raises(InputError, match="audio"):
            source.mark("a word")
    assert source.health.samples > 0.4 * 4936


def test_two_channels_are_two_fingers(tmp_path: Path) -> None:
    tape = np.stack([hum(RATE), np.full(RATE, 100, np.int16)], axis=1)
    with local_sound(tmp_path, tape), open_source("audio:disc/2") as source:
        assert source.descriptor.layout.column_names == ("piezo_index", "piezo_thumb")
        (arrival, *_) = until(source, 100)
    np.testing.assert_allclose(arrival.block.data[:, 1], 100 / 32768.0, rtol=1e-5)


def test_unknown_input_is_refused_with_the_choices(tmp_path: Path) -> None:
    with local_sound(tmp_path, hum(RATE)):
        with pytest.raises(InputError, match=r"audio:violin.*'disc'"):
            open_source("audio:violin").__enter__()
        with pytest.raises(InputError, match="/2"):
            open_source("audio:disc/2").__enter__()
        with open_source("audio") as usual:  # the system's own, here the only one
            assert usual.descriptor.sensor == "sound input disc"
