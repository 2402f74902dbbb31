"""Each bad input gets one sentence, exit code 2, and leaves nothing behind."""

from __future__ import annotations

import csv
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.io import wavfile

from firstcontact.cli.main import main
from firstcontact.core import ChannelKind, Dataset, Finger, Role
from firstcontact.recording import load_dataset

# The kernel refuses to write a file any longer than this, as a full disk does.
FULL = """
import resource, sys
from firstcontact.cli.main import main
resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
sys.exit(main(sys.argv[1:]))
"""
RATE = 5000
LENGTH = 60


def imported(path: Path, out: Path, *more: str) -> Dataset:
    assert main(["import", str(path), "--out", str(out), *more]) == 0
    return load_dataset(out)


@pytest.fixture
def refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Callable[..., None]:
    """Import and expect one sentence with these words, and an untouched disk."""

    def check(path: Path, *words: str, more: tuple[str, ...] = ()) -> None:
        out = tmp_path / "out"
        before = sorted(tmp_path.rglob("*"))
        assert main(["import", str(path), "--out", str(out), *more]) == 2
        message = capsys.readouterr().err
        assert message.count("\n") == 1, message
        for word in words:
            assert word in message
        assert sorted(tmp_path.rglob("*")) == before

    return check


def arrays(**changes: Any) -> dict[str, Any]:
    """Four pinches that import; a change to None leaves an array out."""
    rng = np.random.default_rng(1)
    made = {
        "piezo": rng.normal(size=(4, LENGTH, 2)),
        "force": rng.normal(size=(4, LENGTH, 2, 6)),
        "first_contact": np.array([20, 21, -1, 23]),
        "second_contact": np.array([30, -1, -1, 33]),
        "first_finger": np.array([0, 1, 0, 1]),
        "shore_a": np.array([10.0, 20.0, 10.0, 20.0]),
        "specimen": np.array(["a", "b", "a", "b"]),
        "session": np.array([1, 1, 2, 2]),
        "role": np.array(["train", "train", "train", "test"]),
        "sample_rate_hz": np.array(RATE),
        "piezo_unit": np.array("V"),
        **changes,
    }
    return {name: value for name, value in made.items() if value is not None}


def npz(folder: Path, **changes: Any) -> Path:
    path = folder / "pinches.npz"
    np.savez(path, **arrays(**changes))
    return path


def wavs(folder: Path, rows: dict[str, list[Any]] | None = None, dtype: str = "int16") -> Path:
    """A folder of three WAV files and their table."""
    folder = folder / "wavs"
    (folder / "wav").mkdir(parents=True)
    for i in range(3):
        data = np.arange(LENGTH + i).astype(dtype)
        wavfile.write(folder / "wav" / f"{i}.wav", RATE, data)
    table(folder / "labels.csv", {"file": ["0.wav", "1.wav", "2.wav"], **(rows or {})})
    return folder


def table(path: Path, columns: dict[str, list[Any]]) -> Path:
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
    return path


def long_csv(folder: Path, **changes: Any) -> Path:
    """Two pinches of five samples, a row each."""
    columns: dict[str, Any] = {
        "pinch": [0] * 5 + [1] * 5,
        "piezo_index": list(range(10)),
        "time_s": [round(i / RATE, 6) for i in range(10)],
        "shore_a": [10] * 5 + [20] * 5,
        "first_contact": [2] * 5 + [3] * 5,
        **changes,
    }
    return table(folder / "long.csv", {k: v for k, v in columns.items() if v is not None})


# --- what comes in -----------------------------------------------------------------------


def check_arrays(dataset: Dataset) -> None:
    made = arrays()
    order = [0, 1, 2, 3]
    assert len(dataset) == 4
    for i, pinch in zip(order, dataset.pinches, strict=True):
        assert pinch.data.dtype == np.float32
        assert np.array_equal(pinch.vibration(), made["piezo"][i].astype(np.float32))
        for finger in Finger:
            assert np.array_equal(pinch.force(finger), made["force"][i, :, finger].astype("f4"))
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


def test_npz_comes_in_whole(tmp_path):
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
    path = npz(
        tmp_path, **{k: None for k in arrays() if k not in ("sample_rate_hz",)}
        | {"piezo": counts, "piezo_unit": np.array("counts")},
    )  # fmt: skip
    dataset = imported(path, tmp_path / "out")
    (pinch,) = dataset.pinches
    assert pinch.data.dtype == np.int16
    assert pinch.vibration()[:, 0] == pytest.approx([511 * 3.3 / 1024] + [0.0] * (LENGTH - 1))
    assert not dataset.layout.has_force
    assert dataset.specimens.tolist() == ["unknown"]
    said = " ".join(dataset.notes)
    for what in ("no specimen column", "no session column", "stiffness is not known"):
        assert what in said


@pytest.mark.parametrize("dtype", ["uint8", "int16", "int32", "float32", "float64"])
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
    folder = tmp_path / "w"
    folder.mkdir()
    data = np.stack([np.arange(LENGTH), -np.arange(LENGTH)], axis=1).astype(np.int16)
    wavfile.write(folder / "ü.wav", RATE, data)
    columns = {
        "file": ["ü.wav"],
        "first_contact": [5],
        "second_contact": [9],
        "first_finger": ["thumb"],
    }
    table(folder / "labels.csv", columns)
    (pinch,) = imported(folder, tmp_path / "out").pinches
    assert np.array_equal(pinch.data, data)
    assert pinch.layout.vibration_fingers == (Finger.INDEX, Finger.THUMB)
    assert [(c.finger, c.sample) for c in pinch.truth] == [(Finger.THUMB, 5), (Finger.INDEX, 9)]


def test_long_csv_comes_in(tmp_path):
    dataset = imported(long_csv(tmp_path), tmp_path / "out")
    assert dataset.layout.rate == pytest.approx(RATE)
    assert [p.data[:, 0].tolist() for p in dataset.pinches] == [[0, 1, 2, 3, 4], [5, 6, 7, 8, 9]]
    assert all(p.data.dtype == np.int16 for p in dataset.pinches)
    assert dataset.shore_a.tolist() == [10, 20]
    assert all(p.label.role is Role.TRAIN for p in dataset.pinches)


def test_the_rate_of_a_csv_can_be_given(tmp_path):
    path = long_csv(tmp_path, time_s=None, piezo_index=[0.5] * 10)
    dataset = imported(path, tmp_path / "out", "--rate", "4936")
    assert dataset.layout.rate == 4936
    assert dataset.pinches[0].data.dtype == np.float32


def test_a_csv_may_hold_every_channel(tmp_path):
    names = ["piezo_thumb", *(f"force_{f}_{k}" for f in ("index", "thumb") for k in range(6))]
    names += ["strip_index", "strip_thumb"]
    path = long_csv(tmp_path, **{n: [i] * 10 for i, n in enumerate(names)})
    dataset = imported(path, tmp_path / "out")
    layout = dataset.layout
    assert [c.name for c in layout.channels] == ["piezo_index", *names]
    assert dataset.pinches[0].data[0].tolist() == list(range(0, 1)) + list(range(15))
    assert len(layout.columns(ChannelKind.FORCE, Finger.THUMB)) == 6


def test_an_unknown_column_is_told(tmp_path):
    dataset = imported(long_csv(tmp_path, shore=[1] * 10), tmp_path / "out")
    assert any("not known and left out: shore" in n for n in dataset.notes)


def test_an_empty_output_folder_is_used(tmp_path):
    (tmp_path / "out").mkdir()
    assert len(imported(npz(tmp_path), tmp_path / "out")) == 4


def test_real_impacts_come_in(tmp_path, impacts):
    dataset = imported(impacts, tmp_path / "out")
    assert (len(dataset), dataset.layout.rate) == (54, 16000)
    assert sorted(set(dataset.hardness_rank.tolist())) == [0, 1, 2]
    assert {p.first.sample - p.first_sample for p in dataset.pinches if p.first} == {800}


# --- what does not -----------------------------------------------------------------------

nan = np.nan
hole = np.zeros((4, LENGTH, 2))
hole[2, 7, 1] = nan
BAD_ARRAYS: list[tuple[dict[str, Any], tuple[str, ...]]] = [
    ({"piezo": None}, ("piezo",)),
    ({"sample_rate_hz": None}, ("sample_rate_hz",)),
    ({"piezo_unit": None}, ("piezo_unit",)),
    ({"piezo": hole}, ("piezo", "NaN", "(2, 7, 1)")),
    ({"piezo": np.full((4, LENGTH, 2), np.inf)}, ("piezo", "infinite")),
    ({"piezo": np.full((4, LENGTH, 2), 1e300)}, ("piezo", "beyond 1e+12")),
    ({"piezo": np.full((4, LENGTH, 2), 2**40)}, ("piezo", "32 bits")),
    ({"piezo": np.zeros((4, LENGTH))}, ("piezo", "(4, 60)")),
    ({"piezo": np.zeros((4, LENGTH, 3))}, ("piezo", "(4, 60, 3)")),
    ({"piezo": np.zeros((0, LENGTH, 2))}, ("piezo", "empty")),
    ({"piezo": np.zeros((4, 0, 2))}, ("piezo", "empty")),
    ({"piezo": np.zeros((4, LENGTH, 2), complex)}, ("piezo", "complex")),
    ({"piezo": np.full((4, LENGTH, 2), "x")}, ("piezo", "integers or floats")),
    ({"force": np.zeros((4, LENGTH, 12))}, ("force", "(4, 60, 12)")),
    ({"force": np.zeros((3, LENGTH, 2, 6))}, ("force", "4 pinches")),
    ({"force": np.full((4, LENGTH, 2, 6), nan)}, ("force", "NaN")),
    ({"sample_rate_hz": np.array(1999)}, ("sample_rate_hz", "1999")),
    ({"sample_rate_hz": np.array(1e12)}, ("sample_rate_hz",)),
    ({"sample_rate_hz": np.array(nan)}, ("sample_rate_hz", "nan")),
    ({"sample_rate_hz": np.array(-5000)}, ("sample_rate_hz",)),
    ({"sample_rate_hz": np.array("fast")}, ("sample_rate_hz", "fast")),
    ({"sample_rate_hz": np.array([RATE, RATE])}, ("sample_rate_hz", "one value")),
    ({"piezo_unit": np.array("mV")}, ("piezo_unit", "mV")),
    ({"smoothing_alpha": np.array(0.0)}, ("smoothing_alpha",)),
    ({"smoothing_alpha": np.array(1.5)}, ("smoothing_alpha",)),
    ({"source": np.array("dream")}, ("source", "dream")),
    ({"shore_a": np.array([10.0, 20.0])}, ("shore_a", "4 pinches")),
    ({"shore_a": np.array([10.0, nan, 10, 20])}, ("shore_a", "pinch 1")),
    ({"shore_a": np.array([10.0, 120, 10, 20])}, ("shore_a", "120", "0 to 100")),
    ({"shore_a": np.array(["10", "", "1", "2"])}, ("shore_a", "pinch 1")),
    ({"hardness_rank": np.array([0, 1.5, 1, 0])}, ("hardness_rank", "whole number")),
    ({"specimen": np.array(["a", "", "a", "b"])}, ("specimen", "pinch 1")),
    ({"session": np.array([1.0, nan, 1, 1])}, ("session", "pinch 1")),
    ({"role": np.array(["train", "test", "validate", "test"])}, ("role", "validate")),
    ({"first_contact": np.array([20, 60, 20, 20])}, ("first_contact", "pinch 1", "60")),
    ({"first_contact": np.array([20, -2, 20, 20])}, ("first_contact", "-2")),
    ({"first_contact": np.array([20, 20.5, 20, 20])}, ("first_contact", "20.5")),
    ({"first_contact": np.array([20, nan, 20, 20])}, ("first_contact", "nan")),
    ({"second_contact": np.array([19, -1, -1, 33])}, ("second_contact", "before", "pinch 0")),
    ({"second_contact": np.array([30, -1, 40, 33])}, ("second_contact", "pinch 2")),
    ({"second_contact": np.array([30, -1, -1, 60])}, ("second_contact", "outside")),
    ({"first_finger": np.array([0, 1, 2, 0])}, ("first_finger", "is 2,")),
]


@pytest.mark.parametrize(("changes", "words"), BAD_ARRAYS)
def test_bad_arrays_are_refused(tmp_path, refused, changes, words):
    refused(npz(tmp_path, **changes), "pinches.npz", *words)


def test_bad_hdf5_is_refused(tmp_path, refused):
    path = tmp_path / "p.h5"
    path.write_bytes(b"not HDF5 at all")
    refused(path, "p.h5", "HDF5")
    with h5py.File(path, "w") as file:
        file.create_group("piezo")
    refused(path, "p.h5", "piezo")
    with h5py.File(path, "w") as file:
        for name, values in arrays(shore_a=np.zeros(3)).items():
            if values.ndim:
                file[name] = values.astype("S") if values.dtype.kind == "U" else values
        file.attrs.update(sample_rate_hz=RATE, piezo_unit="V")
    refused(path, "shore_a", "4 pinches")


def test_objects_in_an_npz_are_never_unpickled(tmp_path, refused):
    bomb = np.array([print], dtype=object)
    refused(npz(tmp_path, specimen=bomb), "pinches.npz", "without objects")


def test_a_damaged_npz_is_refused(tmp_path, refused):
    path = npz(tmp_path)
    path.write_bytes(path.read_bytes()[:300])
    refused(path, "pinches.npz")
    path.write_bytes(b"")
    refused(path, "pinches.npz")
    with path.open("wb") as stream:
        np.save(stream, np.zeros(3))
    refused(path, "pinches.npz")


BAD_TABLES: list[tuple[dict[str, list[Any]], tuple[str, ...]]] = [
    ({"file": ["0.wav", "1.wav", "9.wav"]}, ("labels.csv", "'9.wav'", "not in the folder")),
    ({"file": ["0.wav", "1.wav", "../2.wav"]}, ("labels.csv", "'../2.wav'")),
    ({"file": ["0.wav", "1.wav", "1.wav"]}, ("labels.csv", "two rows")),
    ({"sample_rate_hz": [RATE, RATE, 16000]}, ("sample_rate_hz", "2.wav", "5000")),
    ({"sample_rate_hz": [RATE, RATE, "x"]}, ("sample_rate_hz", "x")),
    ({"shore_a": [10, "", 20]}, ("labels.csv", "shore_a", "pinch 1")),
    ({"shore_a": ["nan", 10, 20]}, ("labels.csv", "shore_a")),
    ({"hardness_class": ["soft", "harder", "hard"]}, ("hardness_class", "harder")),
    ({"pre_trigger_samples": [5, 5, 500]}, ("pre_trigger_samples", "500")),
    ({"pre_trigger_samples": [5, 5, 5], "first_contact": [5, 5, 5]}, ("keep one",)),
    ({"material": ["a"] * 3, "object": ["a"] * 3}, ("keep one",)),
    ({"first_contact": [5, 5, 5], "second_contact": [4, 6, 7]}, ("second_contact", "before")),
    ({"role": ["train", "test", "tset"]}, ("role", "tset")),
]


@pytest.mark.parametrize(("rows", "words"), BAD_TABLES)
def test_bad_tables_are_refused(tmp_path, refused, rows, words):
    refused(wavs(tmp_path, rows), *words)


def test_labels_that_do_not_match_the_files_are_refused(tmp_path, refused):
    folder = wavs(tmp_path)
    table(folder / "labels.csv", {"file": ["0.wav", "1.wav"]})
    refused(folder, "labels.csv", "1 WAV files have no row", "2.wav")
    table(folder / "labels.csv", {"name": ["0.wav", "1.wav", "2.wav"]})
    refused(folder, "labels.csv", "file")
    table(folder / "labels.csv", {"file": []})
    refused(folder, "labels.csv", "no rows")
    (folder / "labels.csv").write_bytes(b"file,shore_a\n0.wav\n")
    refused(folder, "labels.csv", "line 2")
    (folder / "labels.csv").write_bytes(b"file,file\n0.wav,1.wav\n")
    refused(folder, "labels.csv", "twice")
    (folder / "labels.csv").write_bytes(b"file\n\xff\xfe.wav\n")
    refused(folder, "labels.csv", "UTF-8")
    (folder / "labels.csv").unlink()
    refused(folder, "labels.csv", "No such file")


def test_wav_files_that_cannot_be_used_are_refused(tmp_path, refused):
    folder = wavs(tmp_path)
    file = folder / "wav" / "1.wav"
    whole = file.read_bytes()
    for damaged in (b"", b"RIFF", whole[:50], b"MP3" + whole):
        file.write_bytes(damaged)
        refused(folder, "1.wav")
    for rate, data, word in (
        (RATE * 2, np.zeros(LENGTH, np.int16), "10000 Hz"),
        (RATE, np.zeros(LENGTH, np.int32), "int32"),
        (RATE, np.zeros((LENGTH, 2), np.int16), "2 channels"),
        (RATE, np.zeros((LENGTH, 3), np.int16), "3 channels"),
    ):
        wavfile.write(file, rate, data)
        refused(folder, "1.wav", word)


def test_wav_with_bad_samples_or_rate_is_refused(tmp_path, refused):
    folder = tmp_path / "w"
    folder.mkdir()
    table(folder / "labels.csv", {"file": ["a.wav"]})
    for rate, data, word in (
        (RATE, np.array([0, nan, 1], np.float32), "NaN"),
        (1000, np.zeros(LENGTH, np.int16), "1000"),
        (RATE, np.zeros(0, np.int16), "no samples"),
    ):
        wavfile.write(folder / "a.wav", rate, data)
        refused(folder, "a.wav", word)


BAD_CSV: list[tuple[dict[str, Any], tuple[str, ...]]] = [
    ({"pinch": None}, ("column pinch",)),
    ({"piezo_index": None}, ("column piezo_index",)),
    ({"time_s": None}, ("rate", "--rate")),
    ({"piezo_index": [*range(9), "x"]}, ("piezo_index", "row 9", "'x'")),
    ({"piezo_index": [*range(9), ""]}, ("piezo_index", "row 9")),
    ({"piezo_index": [*range(9), "nan"]}, ("piezo_index", "NaN")),
    ({"piezo_index": [*range(9), "1e999"]}, ("piezo_index", "infinite")),
    ({"piezo_index": [*range(9), 1e39]}, ("piezo_index", "beyond 1e+12")),
    ({"pinch": [0] * 4 + [1] * 5 + [0]}, ("pinch", "comes again", "row 9")),
    ({"time_s": [0, 1, 2, 2, 4, 5, 6, 7, 8, 9]}, ("time_s", "leaps")),
    ({"time_s": [i / 100 for i in range(10)]}, ("time_s", "100")),
    ({"time_s": [*(i / RATE for i in range(9)), "late"]}, ("time_s", "late")),
    ({"time_s": [i / RATE for i in range(5)] + [i / 9000 for i in range(5)]}, ("time_s", "9000")),
    ({"sample_rate_hz": [9000] * 10}, ("time_s", "sample_rate_hz", "9000")),
    ({"sample_rate_hz": [RATE] * 9 + [1]}, ("sample_rate_hz", "row 9")),
    ({"shore_a": [10] * 6 + [20] * 4}, ("shore_a", "changes", "row 6")),
    ({"shore_a": [10] * 5 + [""] * 5}, ("shore_a", "pinch 1")),
    ({"first_contact": [2] * 5 + [5] * 5}, ("first_contact", "outside")),
    ({"piezo_unit": ["furlong"] * 10}, ("piezo_unit", "furlong")),
    ({"force_index_0": [1] * 10}, ("force_index_1", "or none")),
    ({"pinch": list(range(10)), "first_contact": [0] * 10}, ("one sample",)),
]


@pytest.mark.parametrize(("changes", "words"), BAD_CSV)
def test_bad_csv_is_refused(tmp_path, refused, changes, words):
    refused(long_csv(tmp_path, **changes), "long.csv", *words)


def test_other_paths_are_refused(tmp_path, refused):
    refused(tmp_path / "missing.h5", "missing.h5", "does not exist")
    refused(tmp_path / "missing.csv", "missing.csv", "does not exist")
    refused(tmp_path, "labels.csv")
    (tmp_path / "a.mat").write_bytes(b"x")
    refused(tmp_path / "a.mat", "a.mat", "cannot be read as a MATLAB file")
    (tmp_path / "a.ogg").write_bytes(b"x")
    refused(tmp_path / "a.ogg", "a.ogg", "cannot be imported")
    (tmp_path / "a.mcap").write_bytes(b"x")
    refused(tmp_path / "a.mcap", "is a recording already")
    (tmp_path / "empty.csv").write_bytes(b"")
    refused(tmp_path / "empty.csv", "empty.csv", "no rows")


def test_a_rate_is_only_for_csv(tmp_path, refused):
    refused(npz(tmp_path), "--rate", more=("--rate", "5000"))
    refused(long_csv(tmp_path, time_s=None), "--rate", "200", more=("--rate", "200"))


def test_a_folder_in_use_is_never_touched(tmp_path, capsys):
    path = npz(tmp_path)
    out = tmp_path / "out"
    out.mkdir()
    (out / "mine.txt").write_text("mine")
    assert main(["import", str(path), "--out", str(out)]) == 2
    assert "choose another --out" in capsys.readouterr().err
    assert [p.name for p in out.iterdir()] == ["mine.txt"]


def test_a_place_that_cannot_be_written_is_told(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    out = tmp_path / "file" / "out"
    assert main(["import", str(npz(tmp_path)), "--out", str(out)]) == 2
    assert "cannot be written" in capsys.readouterr().err


def test_a_full_disk_is_told_of_the_place_that_was_asked_for(tmp_path):
    rng = np.random.default_rng(1)
    long = rng.normal(size=(4, 3000, 2)).astype(np.float32)
    big = npz(tmp_path, piezo=long, force=None)
    out = tmp_path / "there" / "out"
    command = [sys.executable, "-c", FULL, "import", str(big), "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert f"{out} cannot be written (File too large)" in done.stderr
    assert list(out.parent.iterdir()) == []
