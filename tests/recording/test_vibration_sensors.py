"""Vibration sensors with or without a finger, with one or several axes, smoothed or not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from import_files import RATE, as_wavs, imported

from firstcontact.contact import ThresholdDetector, detect
from firstcontact.core import (
    Channel,
    ChannelKind,
    Finger,
    Layout,
    VibrationSensor,
    fingertip_layout,
)
from firstcontact.recording import Header, RecordingWriter, load_dataset, read_recording
from firstcontact.signal import contact_windows

#: Written by firstcontact before version 2 of the format, byte for byte.
VERSION_1 = Path(__file__).with_name("version1.mcap")
TOUCH = 600


def ring(n, seed, axes=1):
    """Return noise with a contact in the last axis, shape (n, 1000, axes)."""
    data = np.random.default_rng(seed).normal(0, 0.01, (n, 1000, axes))
    t = np.arange(1000 - TOUCH) / RATE
    data[:, TOUCH:, -1] += np.sin(2 * np.pi * 200 * t) * np.exp(-t / 0.01)
    return data.astype(np.float32)


def arrays(folder, **fields):
    defaults = {"accelerometer": ring(3, 2, axes=3)[:, :, None], "accelerometer_unit": "m/s2"}
    np.savez(
        folder / "x.npz", sample_rate_hz=RATE, first_contact=[TOUCH] * 3, **{**defaults, **fields}
    )
    return folder / "x.npz"


def test_version_1_recording_is_read(tmp_path):
    header = read_recording(VERSION_1).header
    assert header.layout == fingertip_layout()
    assert header.calibration.noise(Finger.THUMB) == 0.002
    old = load_dataset(VERSION_1)
    assert [c.finger for c in old.pinches[0].truth] == [Finger.THUMB, Finger.INDEX]
    with RecordingWriter(tmp_path / "new.mcap", header) as writer:
        writer.pinch(old.pinches[0])
    versions = load_dataset([VERSION_1, tmp_path / "new.mcap"])
    assert np.array_equal(versions.pinches[0].vibration(), versions.pinches[1].vibration())


def test_microphone_belongs_to_no_finger(tmp_path):
    labels = {"first_contact": [TOUCH] * 3, "second_contact": [TOUCH + 100] * 3}
    dataset = imported(as_wavs(tmp_path, ring(3, 1), labels), tmp_path / "out")
    (channel,) = dataset.layout.channels
    assert (channel.sensor, channel.finger) == (VibrationSensor.MICROPHONE, None)
    for pinch in dataset.pinches:
        at = [(c.finger, c.sample - pinch.first_sample) for c in pinch.truth]
        assert at == [(None, TOUCH), (None, TOUCH + 100)]
        assert [c.finger for c in detect(ThresholdDetector(), pinch)] == [None]
    assert contact_windows(dataset, [p.first for p in dataset.pinches], 0.015)[1].all()


def test_three_axes_are_one_channel(tmp_path):
    dataset = imported(arrays(tmp_path, axis=2), tmp_path / "out")
    (channel,) = dataset.layout.channels
    assert (channel.axes, channel.axis, dataset.layout.width) == (3, 2, 3)
    assert dataset.layout.column_names == tuple(f"accelerometer_{a}" for a in "xyz")
    pinch = dataset.pinches[0]
    assert np.array_equal(pinch.vibration(), ring(3, 2, axes=3)[0, :, 2:])
    assert [c.finger for c in detect(ThresholdDetector(), pinch)] == [None]
    assert contact_windows(dataset, [p.first for p in dataset.pinches], 0.015)[1].all()


@pytest.mark.parametrize("axis", [{}, {"axis": 3}, {"axis": "x"}, {"axis": -1}])
def test_vector_sensor_needs_a_valid_axis(tmp_path, check_refused, axis):
    check_refused(arrays(tmp_path, **axis), "axis")


def test_a_second_kind_of_sensor_is_refused(tmp_path, check_refused):
    check_refused(arrays(tmp_path, axis=2), "--sensor", sensor="piezo")
    path = arrays(tmp_path, axis=2, piezo=ring(3, 3), piezo_unit="V")
    check_refused(path, "one kind of sensor")


def test_invalid_sensor_layouts_are_refused():
    channel = Channel("a", ChannelKind.VIBRATION, None, "V")
    assert "no finger" in Layout((channel, replace(channel, name="b")), RATE).why_unusable
    with pytest.raises(ValueError, match="no vibration channel"):
        Header(Layout((replace(channel, kind=ChannelKind.FORCE, sensor=None),), RATE))
    for wrong in ({"axis": 1}, {"kind": ChannelKind.FORCE}):
        with pytest.raises(ValueError, match=r"axis|sensor"):
            replace(channel, **wrong)
