"""A sound file plays as a device does: every sample arrives, in order, and then it ends."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.io import wavfile

from firstcontact.core import InputError
from firstcontact.device import open_source
from firstcontact.device.noise_floor import measure_noise
from firstcontact.signal import resample

RATE = 48_000


def played(path: Path, speed: float = np.inf) -> NDArray[np.float32]:
    with open_source(f"tape:{path}", speed=speed) as source:
        rows, expected = [], 0
        while not source.ended:
            for arrival in source.read(5.0):
                assert arrival.block.first_sample == expected
                rows.append(arrival.block.data)
                expected = arrival.block.end
        assert source.health.samples == expected
        assert source.health.lost_samples == 0
    return np.concatenate(rows)


@pytest.mark.parametrize("kind", [np.uint8, np.int16, np.int32, np.float32])
@pytest.mark.parametrize("channels", [1, 2])
def test_all_samples_arrive_as_fractions_of_full_scale(
    kind: type, channels: int, tmp_path: Path
) -> None:
    time = np.arange(RATE // 4) / RATE
    tone = 0.5 * np.sin(2 * np.pi * 100 * time)[:, None] * np.ones(channels)
    scale, middle = {np.uint8: (127, 128), np.float32: (1, 0)}.get(kind, (np.iinfo("i2").max, 0))
    if kind is np.int32:
        scale = np.iinfo(kind).max
    wavfile.write(tmp_path / "tone.wav", RATE, (scale * tone + middle).astype(kind))
    data = played(tmp_path / "tone.wav")
    rate = 4936
    assert len(data) >= len(time) * rate / RATE
    offline = resample(tone, RATE, rate)
    inner = slice(200, len(offline) - 200)
    delay = round(np.argmax(np.correlate(data[:, 0], offline[inner, 0], "valid"))) - 200
    shifted = data[inner.start + delay : inner.stop + delay]
    assert np.abs(shifted - offline[inner]).max() < 0.05


def test_real_time_takes_as_long_as_the_file(tmp_path: Path) -> None:
    wavfile.write(tmp_path / "rest.wav", RATE, np.zeros(RATE // 10, np.int16))
    assert len(played(tmp_path / "rest.wav", 1.0)) >= 494


def test_other_files_are_refused(tmp_path: Path) -> None:
    (tmp_path / "text.wav").write_text("no sound")
    wavfile.write(tmp_path / "three.wav", RATE, np.zeros((10, 3), np.int16))
    wavfile.write(tmp_path / "still.wav", 0, np.zeros(10, np.int16))
    for name in ("text.wav", "three.wav", "still.wav", "missing.wav"):
        with pytest.raises(InputError, match=name), open_source(f"tape:{tmp_path / name}"):
            pass


def test_file_that_ends_during_the_rest_is_called_too_short(tmp_path: Path) -> None:
    wavfile.write(tmp_path / "short.wav", RATE, np.zeros(RATE // 10, np.int16))
    with (
        open_source(f"tape:{tmp_path / 'short.wav'}", speed=np.inf) as source,
        pytest.raises(InputError, match="long enough"),
    ):
        measure_noise(source)


def spoilt(start: float, end: float, gain: float | NDArray[np.float64], level: int = 0) -> object:
    """Return 6 s of noise with an RMS of 12, scaled from ``start`` to ``end`` (s)."""
    noise = np.random.default_rng(0).normal(0, 12, 6 * RATE)
    part = slice(round(start * RATE), round(end * RATE))
    fade = np.interp(
        np.linspace(0, 1, part.stop - part.start), np.linspace(0, 1, np.size(gain)), np.ravel(gain)
    )
    noise[part] = fade * noise[part] + level
    return np.round(noise).astype(np.int16)


@pytest.mark.parametrize("seconds", [0.2, 1.0, 2.0])
@pytest.mark.parametrize(
    "tape",
    [
        *(spoilt(0, end, 0.0) for end in (0.012, 0.495, 0.56, 1.09, 1.5)),
        spoilt(0, 1.5, 0.0, 700),
        spoilt(0.22, 0.3, 0.0),
        spoilt(0.82, 1.15, 0.0),
        spoilt(0, 0.5, np.linspace(0, 1, 9) ** 2),
        spoilt(0, 0.8, np.array([0.0, 1.0])),
        spoilt(0.7, 6, 1.0, 2000),
    ],
)
def test_noise_is_measured_beside_silence_and_steps(
    tape: object, seconds: float, tmp_path: Path
) -> None:
    wavfile.write(tmp_path / "tape.wav", RATE, tape)
    wavfile.write(tmp_path / "rest.wav", RATE, spoilt(0, 0, 1.0))
    noise = []
    for name in ("tape", "rest"):
        with open_source(f"tape:{tmp_path / name}.wav", speed=np.inf) as source:
            noise += [p.noise for p in measure_noise(source, seconds).piezo]
    assert noise[0] == pytest.approx(noise[1], rel=0.15)


@pytest.mark.parametrize("silent", [0, 1])
def test_silent_channel_is_named(silent: int, tmp_path: Path) -> None:
    both = np.stack([spoilt(0, 0, 1.0)] * 2, axis=1)
    both[:, silent] = 7 * silent
    wavfile.write(tmp_path / "tape.wav", RATE, both)
    with (
        open_source(f"tape:{tmp_path / 'tape.wav'}", speed=np.inf) as source,
        pytest.raises(InputError, match=rf"channel {silent + 1}\) is silent") as error,
    ):
        measure_noise(source)
    assert f"channel {2 - silent}" not in str(error.value)


@pytest.mark.parametrize(("factor", "channels"), [(1.0, 1), (-0.9, 1), (0.0, 2)])
def test_channels_with_one_signal_are_one_sensor(
    factor: float, channels: int, tmp_path: Path
) -> None:
    one, other = np.random.default_rng(0).normal(0, 1000, (2, RATE))
    both = np.stack([one, factor * one + (0.03 if factor else 1) * other], axis=1)
    wavfile.write(tmp_path / "tape.wav", RATE, both.astype(np.int16))
    with open_source(f"tape:{tmp_path / 'tape.wav'}", speed=np.inf) as source:
        assert len(source.descriptor.layout.channels) == channels
        assert (source.descriptor.layout.vibration_fingers == (None,)) == (channels == 1)
