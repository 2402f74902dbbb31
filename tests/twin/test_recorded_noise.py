"""Tests of recorded noise in the twin's pinches."""

import hashlib
from pathlib import Path

import numpy as np
import pytest

from firstcontact.core import (
    Block,
    Channel,
    ChannelKind,
    Finger,
    InputError,
    Layout,
    fingertip_layout,
)
from firstcontact.recording import Header, RecordingWriter, load_dataset, read_recording
from firstcontact.signal import ExponentialSmoothing
from firstcontact.twin.noise import read_noise
from firstcontact.twin.simulation import simulate_recordings


def layout(rate: float = 4936.0, alpha: float = 1.0, unit: str = "V", channels: int = 1) -> Layout:
    names = [
        Channel(f"piezo_{f.name}", ChannelKind.VIBRATION, f, unit, smoothing_alpha=alpha)
        for f in list(Finger)[:channels]
    ]
    return Layout(tuple(names), rate)


def write_quiet(path: Path, volts: np.ndarray, channel_layout: Layout) -> Path:
    with RecordingWriter(path, Header(channel_layout, "real", dtype="float32")) as writer:
        writer.write(Block(volts.astype(np.float32)))
    return path


def tone(hertz: float, rate: float, seconds: float = 4.0, level: float = 0.02) -> np.ndarray:
    t = np.arange(round(seconds * rate)) / rate
    return level * np.sin(2 * np.pi * hertz * t)[:, None]


def line(x: np.ndarray, hertz: float) -> float:
    """Return the amplitude of a signal at a frequency."""
    t = np.arange(len(x)) / 4936.0
    window = np.hanning(len(x))
    return float(2 * abs(np.sum(window * x * np.exp(-2j * np.pi * hertz * t))) / window.sum())


def test_recorded_noise_is_added_to_pinches_and_named_in_the_header(tmp_path: Path) -> None:
    path = write_quiet(tmp_path / "q.mcap", tone(700.0, 4936.0), layout())
    sizes = {"pinches_per_block": 1, "pinches_per_object": 0, "seed": 3, "workers": 1}
    simulate_recordings(tmp_path / "with", noise=read_noise(path), **sizes)  # type: ignore[arg-type]
    simulate_recordings(tmp_path / "without", **sizes)  # type: ignore[arg-type]
    noisy, silent = load_dataset(tmp_path / "with"), load_dataset(tmp_path / "without")
    columns = fingertip_layout().columns(ChannelKind.VIBRATION)
    for noisy_pinch, silent_pinch in zip(noisy.pinches, silent.pinches, strict=True):
        assert noisy_pinch.truth == silent_pinch.truth  # all else is the same pinch
        noisy_level, silent_level = (
            line(p.layout.physical(p.data[:550], columns[:1])[:, 0], 700.0)
            for p in (noisy_pinch, silent_pinch)
        )
        # Of 0.02 V the device's smoothing leaves 0.634 at 700 Hz.
        assert noisy_level == pytest.approx(0.0127, abs=0.004)
        assert silent_level < 0.005
    notes = read_recording(next((tmp_path / "with").glob("*.mcap"))).header.notes
    assert hashlib.sha256(path.read_bytes()).hexdigest() in notes
    assert "q.mcap" in notes


def test_noise_is_unsmoothed_and_resampled(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    white = 0.01 * rng.standard_normal((20_000, 1))
    smoothed = ExponentialSmoothing(0.5).update(white)
    noise = read_noise(write_quiet(tmp_path / "s.mcap", smoothed, layout(alpha=0.5)))
    np.testing.assert_allclose(noise.volts[1:, 0], (white - white.mean())[1:, 0], atol=1e-4)
    fast = read_noise(write_quiet(tmp_path / "f.mcap", tone(300.0, 48_000.0), layout(48_000.0)))
    assert line(fast.volts[200:, 0], 300.0) == pytest.approx(0.02, rel=0.02)


def test_correlation_of_two_sensors_is_preserved(tmp_path: Path) -> None:
    two_channels = np.repeat(np.random.default_rng(0).standard_normal((20_000, 1)), 2, axis=1)
    noise = read_noise(write_quiet(tmp_path / "b.mcap", two_channels, layout(channels=2)))
    index, thumb = noise.draw(1000, np.random.default_rng(1))
    np.testing.assert_array_equal(index, thumb)
    alone = read_noise(write_quiet(tmp_path / "a.mcap", two_channels[:, :1], layout()))
    index, thumb = alone.draw(1000, np.random.default_rng(1))
    assert abs(np.corrcoef(index, thumb)[0, 1]) < 0.2
    assert len(alone.draw(50_000, np.random.default_rng(1))[0]) == 50_000


@pytest.mark.parametrize(
    ("fault", "problem"),
    [
        ("short", "less than 2 s"),
        ("unit", "is in counts"),
        ("loud", "not at rest"),
        ("dead", "not at rest"),
    ],
)
def test_recording_not_at_rest_is_refused(fault: str, problem: str, tmp_path: Path) -> None:
    volts = 0.01 * np.random.default_rng(0).standard_normal((20_000, 1))
    channel_layout = layout(unit="counts" if fault == "unit" else "V")
    volts = volts[:5000] if fault == "short" else volts
    if fault == "loud":
        volts[9000:9500] *= 20
    if fault == "dead":
        volts[:] = 0.0
    with pytest.raises(InputError, match=problem):
        read_noise(write_quiet(tmp_path / "x.mcap", volts, channel_layout))
