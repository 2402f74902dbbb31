"""Any vibration sensor: a finger's or nobody's, one axis or several, smoothed or not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.io import wavfile

from firstcontact.cli.main import main
from firstcontact.contact import ThresholdDetector, detect
from firstcontact.core import (
    Block,
    Channel,
    ChannelKind,
    Contact,
    Dataset,
    Finger,
    Layout,
    Pinch,
    VibrationSensor,
    fingertip_layout,
)
from firstcontact.device import Descriptor
from firstcontact.recording import Header, RecordingWriter, load_dataset, read_recording
from firstcontact.signal import ExponentialSmoothing, WindowStream, contact_windows
from firstcontact.signal._smoothing import missing_smoothing

#: Written by firstcontact before version 2 of the format, byte for byte.
VERSION_1 = Path(__file__).with_name("version1.mcap")
RATE = 5000
TOUCH = 600


def ring(n: int, seed: int, axes: int = 1) -> np.ndarray:
    """Noise, and a contact in the last axis; shape (n, 1000, axes)."""
    data = np.random.default_rng(seed).normal(0, 0.01, (n, 1000, axes))
    t = np.arange(1000 - TOUCH) / RATE
    data[:, TOUCH:, -1] += np.sin(2 * np.pi * 200 * t) * np.exp(-t / 0.01)
    return data.astype(np.float32)


def wavs(folder: Path) -> Path:
    folder.mkdir()
    for k, data in enumerate(ring(3, 1)):
        wavfile.write(folder / f"{k}.wav", RATE, data)
    rows = "".join(f"{k}.wav,{TOUCH},{TOUCH + 100}\n" for k in range(3))
    (folder / "labels.csv").write_text(f"file,first_contact,second_contact\n{rows}")
    return folder


def arrays(folder: Path, **more: object) -> Path:
    given = {"accelerometer": ring(3, 2, axes=3)[:, :, None], "accelerometer_unit": "m/s2"}
    np.savez(folder / "x.npz", sample_rate_hz=RATE, first_contact=[TOUCH] * 3, **{**given, **more})
    return folder / "x.npz"


def imported(path: Path, out: Path, *more: str) -> Dataset:
    assert main(["import", str(path), "--out", str(out), *more]) == 0
    return load_dataset(out)


def test_a_recording_of_version_1_is_what_it_was(tmp_path: Path) -> None:
    header = read_recording(VERSION_1).header
    assert header.layout == fingertip_layout()
    assert header.calibration is not None
    assert header.calibration.noise(Finger.THUMB) == 0.002
    old = load_dataset(VERSION_1)
    assert [c.finger for c in old.pinches[0].truth] == [Finger.THUMB, Finger.INDEX]
    with RecordingWriter(tmp_path / "new.mcap", header) as writer:
        writer.pinch(old.pinches[0])
    both = load_dataset([VERSION_1, tmp_path / "new.mcap"])
    assert np.array_equal(both.pinches[0].vibration(), both.pinches[1].vibration())


@pytest.mark.parametrize("sensor", VibrationSensor)
def test_a_device_says_its_layout_and_is_understood(sensor: VibrationSensor) -> None:
    alone = Channel("x", ChannelKind.VIBRATION, None, "V", sensor=sensor, axes=3, axis=1)
    for layout in (fingertip_layout(), Layout((alone,), 2000.0, 0.5)):
        assert Descriptor.from_text(Descriptor(layout).to_text()).layout == layout


def test_a_microphone_is_nobodys_finger(tmp_path: Path) -> None:
    dataset = imported(wavs(tmp_path / "w"), tmp_path / "out")
    (channel,) = dataset.layout.channels
    assert (channel.sensor, channel.finger) == (VibrationSensor.MICROPHONE, None)
    for pinch in dataset.pinches:
        at = [(c.finger, c.sample - pinch.first_sample) for c in pinch.truth]
        assert at == [(None, TOUCH), (None, TOUCH + 100)]
        assert [c.finger for c in detect(ThresholdDetector(), pinch)] == [None]
    assert contact_windows(dataset, [p.first for p in dataset.pinches], 0.015)[1].all()


def test_what_recorded_wav_files_can_be_said(tmp_path: Path) -> None:
    folder = wavs(tmp_path / "w")
    heard = imported(folder, tmp_path / "a")
    piezo = imported(folder, tmp_path / "b", "--sensor", "piezo")
    assert piezo.layout.vibration_fingers == (Finger.INDEX,)
    windows = [contact_windows(d, [p.first for p in d.pinches], 0.015)[0] for d in (heard, piezo)]
    assert np.array_equal(*windows)


def test_a_sensor_that_the_file_names_is_not_said_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    more = ["--out", str(tmp_path / "out"), "--sensor", "piezo"]
    assert main(["import", str(arrays(tmp_path, axis=2)), *more]) == 2
    assert "leave --sensor out" in capsys.readouterr().err


def test_three_axes_are_one_channel(tmp_path: Path) -> None:
    dataset = imported(arrays(tmp_path, axis=2), tmp_path / "out")
    (channel,) = dataset.layout.channels
    assert (channel.axes, channel.axis, dataset.layout.width) == (3, 2, 3)
    assert dataset.layout.column_names == tuple(f"accelerometer_{a}" for a in "xyz")
    pinch = dataset.pinches[0]
    assert np.array_equal(pinch.vibration(), ring(3, 2, axes=3)[0, :, 2:])
    assert [c.finger for c in detect(ThresholdDetector(), pinch)] == [None]
    windows, kept = contact_windows(dataset, [p.first for p in dataset.pinches], 0.015)
    assert kept.all()
    stream = WindowStream(dataset.layout, [0.015])
    assert pinch.first is not None
    (live,) = stream.update(Block(pinch.data, pinch.first_sample), [pinch.first])
    assert np.array_equal(live.samples, windows[0])


@pytest.mark.parametrize("axis", [{}, {"axis": 3}, {"axis": "x"}, {"axis": -1}])
def test_a_vector_says_which_axis_stands_for_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], axis: dict[str, object]
) -> None:
    path = arrays(tmp_path, **axis)
    assert main(["import", str(path), "--out", str(tmp_path / "out")]) == 2
    assert "axis" in capsys.readouterr().err


def test_two_sensors_in_a_file_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = arrays(tmp_path, axis=2, piezo=ring(3, 3), piezo_unit="V")
    assert main(["import", str(path), "--out", str(tmp_path / "out")]) == 2
    assert "one of them at a time" in capsys.readouterr().err


@pytest.mark.parametrize("to", ["csv", "hdf5"])
@pytest.mark.parametrize("make", [wavs, arrays])
def test_sensors_go_out_and_come_back(tmp_path: Path, to: str, make: Callable[..., Path]) -> None:
    path = make(tmp_path / "w") if make is wavs else make(tmp_path, axis=1)
    there = imported(path, tmp_path / "a")
    out = tmp_path / f"x.{'h5' if to == 'hdf5' else to}"
    assert main(["export", str(tmp_path / "a"), "--to", to, "--out", str(out)]) == 0
    back = imported(out, tmp_path / "b")
    assert back.layout.vibration == there.layout.vibration
    for one, other in zip(there.pinches, back.pinches, strict=True):
        assert np.array_equal(one.vibration(), other.vibration())
        assert [c.finger for c in one.truth] == [c.finger for c in other.truth]


def test_each_channel_is_smoothed_once() -> None:
    raw, smoothed = (
        Channel(f.name, ChannelKind.VIBRATION, f, "V", smoothing_alpha=alpha)
        for f, alpha in zip(Finger, (1.0, 0.5), strict=True)
    )
    x = np.random.default_rng(0).normal(size=(50, 2))
    smoothing = missing_smoothing(Layout((raw, smoothed), RATE))
    assert smoothing is not None
    y = smoothing.update(x)
    assert np.array_equal(y[:, 1], x[:, 1])
    assert np.array_equal(y[:, 0], ExponentialSmoothing().update(x)[:, 0])
    assert missing_smoothing(Layout((smoothed,), RATE)) is None


def test_layouts_that_name_a_sensor_twice_are_refused() -> None:
    one = Channel("a", ChannelKind.VIBRATION, None, "V")
    assert "no finger" in Layout((one, replace(one, name="b")), RATE).fault
    with pytest.raises(ValueError, match="no vibration channel"):
        Header(Layout((replace(one, kind=ChannelKind.FORCE, sensor=None),), RATE))
    for wrong in ({"axis": 1}, {"kind": ChannelKind.FORCE}):
        with pytest.raises(ValueError, match=r"axis|sensor"):
            replace(one, **wrong)


def test_contacts_of_no_finger_are_kept(tmp_path: Path) -> None:
    layout = Layout((Channel("m", ChannelKind.VIBRATION, None, "V"),), RATE)
    truth = (Contact(None, 20, 20), Contact(None, 40, 40))
    with RecordingWriter(tmp_path / "a.mcap", Header(layout)) as writer:
        writer.pinch(Pinch(np.zeros((60, 1), np.int16), layout, truth=truth))
    assert load_dataset(tmp_path / "a.mcap").pinches[0].truth == truth
