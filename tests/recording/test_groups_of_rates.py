"""Layouts with groups of different rates, such as a BioTac's 2200 Hz and 100 Hz."""

from dataclasses import replace

import h5py
import numpy as np
import pytest

from firstcontact.cli.main import main
from firstcontact.core import (
    Block,
    Channel,
    ChannelKind,
    Contact,
    Finger,
    Group,
    InputError,
    Layout,
    Pinch,
    VibrationSensor,
)
from firstcontact.device.replay import ReplaySource
from firstcontact.recording import (
    EXPORTERS,
    Header,
    RecordingWriter,
    export,
    load_dataset,
    read_recording,
    write_dataset,
)
from firstcontact.signal import resample_dataset

SLOW = Layout(
    tuple(Channel(f"e{k}", ChannelKind.FORCE, Finger.INDEX, "", 0.5, taxel=k) for k in range(3)),
    100.0,
)
PAC = Channel("pac", ChannelKind.VIBRATION, Finger.INDEX, "", sensor=VibrationSensor.HYDROPHONE)
LAYOUT = Layout((PAC,), 2200.0, groups=(Group("electrodes", SLOW),))


def fast(first, n):
    return Block(np.arange(first, first + n, dtype=np.int16)[:, None], first)


def slow(first, n):
    return Block(np.arange(first, first + n, dtype=np.int16)[:, None].repeat(3, 1), first)


@pytest.fixture
def recording_path(tmp_path):
    """Return the path of a recording: 2 s at both rates, then 0.5 s without the slower group."""
    path = tmp_path / "biotac.mcap"
    with RecordingWriter(path, Header(LAYOUT, "real")) as writer:
        for tenth in range(20):
            writer.write(fast(220 * tenth, 220))
            writer.write(slow(10 * tenth, 10), "electrodes")
        truth = (Contact(Finger.INDEX, 4600, 4600),)
        writer.pinch(Pinch(fast(4400, 1100).data, LAYOUT, first_sample=4400, truth=truth))
    return path


def test_each_group_keeps_its_rate(recording_path):
    recording = read_recording(recording_path)
    assert recording.header.layout == LAYOUT
    assert recording.skipped == ()
    (electrodes,) = recording.groups["electrodes"]
    assert np.array_equal(electrodes.data, slow(0, 200).data)
    assert recording.samples == 5500


def test_pinch_has_the_group_samples_of_its_time(tmp_path):
    first, n = 2201, 1099
    pinch = Pinch(
        fast(first, n).data, LAYOUT, first_sample=first, groups={"electrodes": slow(101, 49)}
    )
    with RecordingWriter(tmp_path / "a.mcap", Header(LAYOUT)) as writer:
        writer.pinch(pinch)
    dataset = load_dataset(tmp_path / "a.mcap")
    for resampled in (dataset, resample_dataset(dataset, 4400.0)):
        times, values = resampled.pinches[0].group("electrodes")
        assert times[0] == pytest.approx(1.01 - first / 2200)
        assert np.diff(times) == pytest.approx(0.01)
        assert np.array_equal(values, 0.5 * slow(101, 49).data)
    export(dataset, EXPORTERS["hdf5"], tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5") as file:
        for name, expected in zip(
            ("time_s", "values"), dataset[0].group("electrodes"), strict=True
        ):
            assert np.array_equal(file[f"groups/electrodes/{name}"][0], expected)
    # And on into recordings of their own.
    (tmp_path / "b").mkdir()
    write_dataset(dataset, tmp_path / "b", Header(LAYOUT))
    reloaded = load_dataset(tmp_path / "b").pinches[0]
    assert np.array_equal(reloaded.groups["electrodes"].data, slow(101, 49).data)


def test_incomplete_group_is_dropped_from_the_pinch(recording_path):
    assert "electrodes" not in load_dataset(recording_path).pinches[0].groups


def test_recordings_with_and_without_a_group_load_together(recording_path):
    pinch = Pinch(fast(0, 1100).data, replace(LAYOUT, groups=()))
    with RecordingWriter(
        recording_path.with_name("a.mcap"), Header(pinch.layout, "real")
    ) as writer:
        writer.pinch(pinch)
    assert len(load_dataset(recording_path.parent)) == 2


def test_damaged_first_chunk_keeps_the_groups(recording_path):
    data = bytearray(recording_path.read_bytes())
    at = data.index(b"/samples/electrodes")
    data[at] ^= 1
    recording_path.write_bytes(data)
    recording = read_recording(recording_path)
    assert recording.skipped != ()
    assert sum(len(s.data) for s in recording.groups["electrodes"]) == 200


def test_writer_refuses_invalid_group_blocks(tmp_path):
    with RecordingWriter(tmp_path / "a.mcap", Header(LAYOUT)) as writer:
        with pytest.raises(InputError, match="'other'"):
            writer.write(slow(0, 10), "other")
        with pytest.raises(InputError, match="3 columns"):
            writer.write(fast(0, 10), "electrodes")


def test_inspect_shows_the_groups(recording_path, capsys):
    assert main(["inspect", str(recording_path)]) == 0
    assert "electrodes: 3 channels at 100 Hz, 200 samples" in capsys.readouterr().out
    out = recording_path.with_suffix(".csv")
    assert main(["export", str(recording_path), "--to", "csv", "--out", str(out)]) == 0
    assert "electrodes are left out" in capsys.readouterr().out
    with ReplaySource(recording_path, float("inf")) as source:
        assert source.descriptor.layout == replace(LAYOUT, groups=())
