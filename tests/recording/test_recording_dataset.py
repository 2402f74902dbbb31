import re
import shutil
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact import import_recordings
from firstcontact.core import Contact, Dataset, Finger, InputError, Label, Pinch, Role
from firstcontact.recording import Header, PinchMark, RecordingWriter, load_dataset, write_dataset
from firstcontact.recording.dataset import pause_between


@pytest.fixture
def pinches(layout, counted):
    recorded = []
    for i in range(6):
        label = Label(
            "block", 10.0 * i, None, f"b{i}", f"s/{i % 2}", Role(("train", "test")[i > 3])
        )
        truth = (Contact(Finger.THUMB, 40, 40), Contact(Finger.INDEX, 55, 55))[: i % 3]
        recorded.append(Pinch(counted(0, 100).data, layout, label, 0, truth))
    return pause_between(recorded)


def test_dataset_round_trips_through_its_folder(tmp_path, layout, pinches):
    files = write_dataset(Dataset(pinches), tmp_path, Header(layout, "synthetic"))
    assert [f.name for f in files] == ["000_s-0.mcap", "001_s-1.mcap"]
    dataset = load_dataset(tmp_path)
    assert (dataset.source, dataset.notes, len(dataset)) == ("synthetic", (), 6)
    expected = [*pinches[0::2], *pinches[1::2]]
    for pinch, expected_pinch in zip(dataset.pinches, expected, strict=True):
        assert (pinch.label, pinch.truth, pinch.first_sample) == (
            expected_pinch.label,
            expected_pinch.truth,
            expected_pinch.first_sample,
        )
        assert np.array_equal(pinch.data, expected_pinch.data)
        assert pinch.data.dtype == np.int16
    by_files = load_dataset(list(files))
    assert by_files.specimens.tolist() == dataset.specimens.tolist()


def test_pinch_across_a_gap_is_skipped_with_a_note(tmp_path, layout, counted):
    with RecordingWriter(tmp_path / "a.mcap", Header(layout, session="s")) as writer:
        writer.write(counted(0, 100))
        writer.write(counted(120, 100))
        writer.mark(PinchMark(0, 0, 90))
        writer.mark(PinchMark(1, 80, 130))
        writer.mark(PinchMark(2, 125, 220))
        writer.mark(PinchMark(3, 125, 220, epoch=1))
    dataset = load_dataset(tmp_path / "a.mcap")
    assert [p.first_sample for p in dataset.pinches] == [0, 125]
    assert dataset.sessions.tolist() == ["s", "s"]  # from the header, where the mark has none
    text = " ".join(dataset.notes)
    assert "20 samples are missing" in text
    assert "pinch 1 has missing samples" in text
    assert "pinch 3 has missing samples" in text


@pytest.mark.parametrize(
    ("change", "field"),
    [
        (lambda h: replace(h, layout=replace(h.layout, rate=2500.0)), "rate"),
        (lambda h: replace(h, layout=replace(h.layout, smoothing_alpha=0.5)), "layout"),
        (lambda h: replace(h, source="twin"), "source"),
    ],
)
def test_recordings_of_different_kinds_are_not_mixed(tmp_path, layout, pinches, change, field):
    header = Header(layout, "real")
    for name, h in (("a.mcap", header), ("b.mcap", change(header))):
        with RecordingWriter(tmp_path / name, h) as writer:
            writer.pinch(replace(pinches[0], layout=h.layout))
    with pytest.raises(InputError, match=rf"b\.mcap.* {field} "):
        load_dataset(tmp_path)


def test_folders_without_pinches_are_refused(tmp_path, small):
    empty = tmp_path / "empty"
    empty.mkdir()
    with pytest.raises(InputError, match=empty.name):
        load_dataset(empty)
    with pytest.raises(InputError, match=f"{re.escape(small.name)} holds no whole pinch"):
        load_dataset(small)
    with pytest.raises(InputError, match="no whole pinch"):
        load_dataset([])


def test_subfolders_are_read_in_name_order(tmp_path, layout, pinches):
    for folder, pinch in (("b", pinches[1]), ("a/deep", pinches[0])):
        (tmp_path / folder).mkdir(parents=True)
        write_dataset(Dataset((pinch,)), f"{tmp_path}/{folder}", Header(layout))
    assert load_dataset(tmp_path).specimens.tolist() == ["b0", "b1"]
    assert load_dataset(str(tmp_path / "b")).specimens.tolist() == ["b1"]


def test_recordings_of_one_layout_load_together_whatever_their_sample_types(
    tmp_path, layout, pinches
):
    expected = []
    for number, dtype in enumerate(("int32", "int16", "float32")):
        of_type = [replace(p, data=p.data[: 99 + number].astype(dtype)) for p in pinches[::2]]
        with RecordingWriter(tmp_path / f"{number}.mcap", Header(layout, dtype=dtype)) as writer:
            for pinch in of_type:
                writer.pinch(pinch)
        expected += of_type
    for one, other in zip(load_dataset(tmp_path), expected, strict=True):
        assert one.data.dtype == other.data.dtype
        assert np.array_equal(one.data, other.data)


def test_a_recording_named_twice_is_read_once(tmp_path, layout, pinches, monkeypatch):
    folder = tmp_path / "all"
    folder.mkdir()
    file, _ = write_dataset(Dataset(pinches), folder, Header(layout))
    monkeypatch.chdir(tmp_path)
    link = tmp_path / "link"
    link.symlink_to(folder)
    named = [folder, file, Path("all") / file.name, link, link / file.name]
    for paths in (named, named[::-1], sorted(tmp_path.rglob("*"))):
        data = load_dataset(paths)
        assert sorted(data.specimens.tolist()) == [f"b{i}" for i in range(6)]


def test_copies_of_recordings_are_left_out_and_named(tmp_path, layout, pinches):
    first, second = write_dataset(Dataset(pinches), tmp_path, Header(layout))
    expected = load_dataset(tmp_path)
    (tmp_path / "backup").mkdir()
    for file in (first, second):
        shutil.copy(file, tmp_path / "backup" / f"other-{file.name}")
    data = load_dataset(tmp_path)
    assert sorted(data.specimens.tolist()) == sorted(expected.specimens.tolist())
    assert len(data.losses) == 2
    for file, loss in zip((first, second), data.losses, strict=True):
        assert str(file) in loss
        assert f"other-{file.name}" in loss


def test_recordings_that_differ_in_one_sample_are_no_copies(tmp_path, layout, pinches):
    changed = pinches[0].data.copy()
    changed[-1, -1] += 1
    for name, data in (("a", pinches[0].data), ("b", changed)):
        with RecordingWriter(tmp_path / f"{name}.mcap", Header(layout)) as writer:
            writer.pinch(replace(pinches[0], data=data))
    assert len(load_dataset(tmp_path)) == 2


@given(st.lists(st.sampled_from(["b", "a", "", "c/1"]), min_size=1, max_size=12))
def test_imported_pinches_are_in_the_order_of_loading(sessions):
    with tempfile.TemporaryDirectory() as folder:
        volts = np.arange(len(sessions))[:, None, None] + np.zeros((1, 50, 1))
        labels = {"specimen": np.arange(len(sessions)), "session": [f"s{s}" for s in sessions]}
        np.savez(f"{folder}/x", piezo=volts, sample_rate_hz=8000, piezo_unit="V", **labels)
        imported = import_recordings(f"{folder}/x.npz", f"{folder}/out")
        loaded = load_dataset(f"{folder}/out")
    for one, other in zip(imported, loaded, strict=True):
        assert one.label == other.label
        assert one.data[0, 0] == other.data[0, 0] == int(one.label.specimen)
