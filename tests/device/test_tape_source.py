"""A sound file plays as a device does: every sample arrives, in order, and then it ends."""

from __future__ import annotations

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
        with (
            pytest.raises(InputError, match=name),
            open_source(f"tape:{tmp_path / name}"),
        ):
            pass


def test_file_that_ends_during_the_rest_is_called_too_short(tmp_path: Path) -> None:
    wavfile.write(tmp_path / "short.wav", RATE, np.zeros(RATE // 10, np.int16))
    with (
        open_source(f"tape:{tmp_path / 'short.wav'}", speed=np.inf) as source,
        pytest.raises(InputError, match="long enough"),
    ):
        measure_noise(source)
