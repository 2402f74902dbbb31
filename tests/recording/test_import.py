"""Import writes complete recordings to the requested folder."""

import h5py
import numpy as np
import pytest
from import_files import LENGTH, RATE, arrays, as_npz, as_wavs, imported, long_csv, npz, wavs

from firstcontact.cli.main import main
from firstcontact.core import Finger


def check_arrays(dataset):
    made = arrays()
    for pinch, piezo, force in zip(dataset, made["piezo"], made["force"], strict=True):
        assert pinch.data.dtype == np.float32
        assert np.array_equal(pinch.vibration(), piezo.astype(np.float32))
        for finger in Finger:
            assert np.array_equal(pinch.force(finger), force[:, finger].astype("f4"))
    first = [p.first and (p.first.finger, p.first.sample - p.first_sample) for p in dataset.pinches]
    assert first == [(Finger.INDEX, 20), (Finger.THUMB, 21), None, (Finger.THUMB, 23)]
    second = [p.second and p.second.sample - p.first_sample for p in dataset.pinches]
    assert second == [30, None, None, 33]
    assert dataset.shore_a.tolist() == [10, 20, 10, 20]
    assert dataset.specimens.tolist() == ["a", "b", "a", "b"]
    assert dataset.sessions.tolist() == ["1", "1", "2", "2"]
    assert dataset.test.tolist() == [False, False, False, True]
    assert dataset.layout.rate == RATE
    assert dataset.source == "unknown"


def test_npz_is_imported_completely(tmp_path):
    check_arrays(imported(npz(tmp_path), tmp_path / "out"))


@pytest.mark.parametrize("of_piezo", [False, True])
def test_hdf5_comes_in_whole_with_strings_as_bytes(tmp_path, of_piezo):
    made = arrays()
    with h5py.File(tmp_path / "p.h5", "w") as file:
        for name, values in made.items():
            if values.ndim:
                file[name] = values.astype("S") if values.dtype.kind == "U" else values
        attributes = file["piezo"].attrs if of_piezo else file.attrs
        attributes["sample_rate_hz"] = RATE
        attributes["piezo_unit"] = b"V" if of_piezo else "V"
        attributes["smoothing_alpha"] = 0.5
    dataset = imported(tmp_path / "p.h5", tmp_path / "out")
    check_arrays(dataset)
    assert {c.smoothing_alpha for c in dataset.layout.vibration} == {0.5}


def test_counts_are_ten_bits_around_half_the_supply(tmp_path):
    counts = np.full((1, LENGTH, 1), 512, np.uint16)
    counts[0, 0, 0] = 1023
    dataset = imported(as_npz(tmp_path, counts, piezo_unit="counts"), tmp_path / "out")
    (pinch,) = dataset.pinches
    assert pinch.data.dtype == np.int16
    assert pinch.vibration()[:, 0] == pytest.approx([511 * 3.3 / 1024] + [0.0] * (LENGTH - 1))
    assert dataset.layout.width == 1
    assert dataset.specimens.tolist() == ["unknown"]
    text = " ".join(dataset.notes)
    for kind in ("no specimen column", "no session column", "stiffness is not known"):
        assert kind in text


@pytest.mark.parametrize("dtype", ["uint8", "int16", "float64"])
def test_wav_comes_in_with_its_table(tmp_path, dtype):
    rows = {
        "material": ["foam", "wood", "foam"],
        "hardness_class": ["soft", "Hard", "soft"],
        "pre_trigger_samples": [12, 13, -1],
        "sample_rate_hz": [RATE] * 3,
        "comment": ["", "ä", ""],
    }
    dataset = imported(wavs(tmp_path, rows, dtype), tmp_path / "out")
    assert dataset.hardness_rank.tolist() == [0, 2, 0]
    assert dataset.objects.tolist() == dataset.specimens.tolist() == ["foam", "wood", "foam"]
    assert [p.first and p.first.sample - p.first_sample for p in dataset.pinches] == [12, 13, None]
    full = {"uint8": 128, "int16": 2**15, "int32": 2**31}.get(dtype, 1)
    zero = 128 if dtype == "uint8" else 0
    for i, pinch in enumerate(dataset.pinches):
        assert pinch.vibration()[:, 0] == pytest.approx((np.arange(LENGTH + i) - zero) / full)
    assert dataset.layout.channels[0].unit == "full scale"


def test_two_channel_wav_is_both_fingers(tmp_path):
    data = np.stack([np.arange(LENGTH), -np.arange(LENGTH)], axis=1).astype(np.int16)
    labels = {"first_contact": [5], "second_contact": [9], "first_finger": ["thumb"]}
    (pinch,) = imported(as_wavs(tmp_path, data[None], labels), tmp_path / "out")
    assert np.array_equal(pinch.data, data)
    assert pinch.layout.vibration_fingers == (Finger.INDEX, Finger.THUMB)
    assert [(c.finger, c.sample) for c in pinch.truth] == [(Finger.THUMB, 5), (Finger.INDEX, 9)]


def test_the_rate_of_a_csv_can_be_given(tmp_path):
    path = long_csv(tmp_path, time_s=None, piezo_index=[0.5] * 10)
    dataset = imported(path, tmp_path / "out", "--rate", "4936")
    assert dataset.layout.rate == 4936
    assert dataset.pinches[0].data.dtype == np.float32


def test_an_unknown_column_is_reported(tmp_path):
    dataset = imported(long_csv(tmp_path, shore=[1] * 10), tmp_path / "out")
    assert any("unknown columns were left out: shore" in n for n in dataset.notes)
    assert not any("did you mean" in n for n in dataset.notes)  # the file has a shore_a
    misspelt = imported(long_csv(tmp_path, shore_a=None, shore=[1] * 10), tmp_path / "other")
    assert any("did you mean shore_a" in note for note in misspelt.notes)


def test_real_impacts_are_imported(tmp_path, impacts):
    dataset = imported(impacts, tmp_path / "out")
    assert (len(dataset), dataset.layout.rate) == (54, 16000)
    assert sorted(set(dataset.hardness_rank.tolist())) == [0, 1, 2]
    assert {p.first.sample - p.first_sample for p in dataset.pinches if p.first} == {800}


def test_other_paths_are_refused(tmp_path, check_refused):
    check_refused(tmp_path, tmp_path.name)  # an empty folder
    check_refused(tmp_path / "missing.h5", "missing.h5")
    for name in ("a.mat", "a.ogg", "a.mcap", "a.csv"):
        (tmp_path / name).write_bytes(b"x")
        check_refused(tmp_path / name, name)


def test_a_rate_is_only_for_csv(tmp_path, check_refused):
    check_refused(npz(tmp_path), "--rate", rate="5000")
    check_refused(long_csv(tmp_path, time_s=None), "--rate", "200", rate="200")


def test_a_folder_in_use_is_never_touched(tmp_path, capsys):
    path = npz(tmp_path)
    out = tmp_path / "out"
    out.mkdir()
    (out / "mine.txt").write_text("mine")
    assert main(["import", str(path), "--out", str(out)]) == 2
    assert str(out) in capsys.readouterr().err
    assert [p.name for p in out.iterdir()] == ["mine.txt"]
