"""Each invalid input gives one sentence and exit code 2, and leaves no files."""

from __future__ import annotations

import struct
from typing import Any

import h5py
import numpy as np
import pytest
from import_files import LENGTH, RATE, arrays, long_csv, npz, table, wavs
from scipy.io import wavfile

nan = np.nan
hole = np.zeros((4, LENGTH, 2))
hole[2, 7, 1] = nan
BAD_ARRAYS: list[tuple[dict[str, Any], tuple[str, ...]]] = [
    ({"piezo": None}, ("piezo",)),
    ({"sample_rate_hz": None}, ("sample_rate_hz",)),
    ({"piezo_unit": None}, ("piezo_unit",)),
    ({"piezo": hole}, ("piezo", "NaN", "(2, 7, 1)")),
    ({"piezo": np.full((4, LENGTH, 2), 1e300)}, ("piezo", "beyond 1e+12")),
    ({"piezo": np.full((4, LENGTH, 2), 2**40)}, ("piezo", "32 bits")),
    ({"piezo": np.zeros((4, LENGTH))}, ("piezo", "(4, 60)")),
    ({"piezo": np.zeros((0, LENGTH, 2))}, ("piezo", "empty")),
    ({"piezo": np.zeros((4, LENGTH, 2), complex)}, ("piezo", "complex")),
    ({"piezo": np.zeros((LENGTH, 4, 2)), "force": None}, ("piezo", "60 pinches of 4", "transpose")),
    ({"force": np.zeros((4, LENGTH, 12))}, ("force", "(4, 60, 12)")),
    ({"force": np.full((4, LENGTH, 2, 6), 300)}, ("force", "300 V", "'force_unit' to counts")),
    (
        {"force": np.full((4, LENGTH, 2, 6), 65535), "force_unit": np.array("counts")},
        ("force", "65535 counts", "'force_unit' to V"),
    ),
    ({"force_unit": np.array("N")}, ("force_unit", "'N'", "V, counts")),
    ({"sample_rate_hz": np.array(1999)}, ("sample_rate_hz", "1999")),
    ({"sample_rate_hz": np.array(nan)}, ("sample_rate_hz", "nan")),
    ({"sample_rate_hz": np.array([RATE, RATE])}, ("sample_rate_hz", "single value")),
    ({"piezo_unit": np.array("mV")}, ("piezo_unit", "mV")),
    ({"smoothing_alpha": np.array(0.0)}, ("smoothing_alpha",)),
    ({"source": np.array("dream")}, ("source", "dream")),
    ({"shore_a": np.array([10.0, 20.0])}, ("shore_a", "4 pinches")),
    ({"shore_a": np.array([10.0, nan, 10, 20])}, ("shore_a", "pinch 1")),
    ({"shore_a": np.array([10.0, 120, 10, 20])}, ("shore_a", "120", "0 to 100")),
    ({"hardness_rank": np.array([0, 1.5, 1, 0])}, ("hardness_rank", "whole number")),
    ({"specimen": np.array(["a", "", "a", "b"])}, ("specimen", "pinch 1")),
    ({"session": np.array([1.0, nan, 1, 1])}, ("session", "pinch 1")),
    ({"role": np.array(["train", "test", "validate", "test"])}, ("role", "validate")),
    ({"first_contact": np.array([20, 60, 20, 20])}, ("first_contact", "pinch 1", "60")),
    ({"first_contact": np.array([20, 20.5, 20, 20])}, ("first_contact", "20.5")),
    ({"second_contact": np.array([19, -1, -1, 33])}, ("second_contact", "before", "pinch 0")),
    ({"second_contact": np.array([30, -1, 40, 33])}, ("second_contact", "pinch 2")),
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
    ({"shore_a": [10, "", 20]}, ("labels.csv", "shore_a", "line 3")),
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
    refused(folder, "labels.csv", "no row for 1 .wav file", "2.wav")
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
    refused(folder, "labels.csv", "--labels", "--events")


def test_wav_files_that_cannot_be_used_are_refused(tmp_path, refused):
    folder = wavs(tmp_path)
    file = folder / "wav" / "1.wav"
    content = file.read_bytes()
    for damaged in (b"", b"RIFF", content[:50], b"MP3" + content):
        file.write_bytes(damaged)
        refused(folder, "1.wav")
    for rate, data, word in (
        (RATE * 2, np.zeros(LENGTH, np.int16), "10000 Hz"),
        (RATE, np.zeros(LENGTH, np.int32), "int32"),
        (RATE, np.zeros((LENGTH, 2), np.int16), "2 channels"),
        (RATE, np.zeros((LENGTH, 3), np.int16), "3 channels"),
        (RATE, np.zeros((LENGTH, 3), np.int16), "column 'channel'"),
        (RATE, np.zeros((LENGTH, 2), np.int16), "--events"),
    ):
        wavfile.write(file, rate, data)
        refused(folder, "1.wav", word)


@pytest.mark.parametrize(
    ("at", "form", "value"),
    [
        (34, "<H", 7),
        (34, "<H", 8),
        (32, "<H", 4),
        (22, "<H", 2),
        (24, "<I", 2 * RATE),
        (28, "<I", RATE),
    ],
)
def test_a_wav_header_that_contradicts_itself_is_refused(tmp_path, refused, at, form, value):
    folder = wavs(tmp_path)
    file = folder / "wav" / "1.wav"
    raw = bytearray(file.read_bytes())
    struct.pack_into(form, raw, at, value)
    file.write_bytes(raw)
    refused(folder, "1.wav")


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
    ({"pinch": None}, ("column 'pinch'",)),
    ({"piezo_index": None}, ("column 'piezo_index'",)),
    ({"time_s": None}, ("rate", "--rate")),
    ({"piezo_index": [*range(9), "x"]}, ("piezo_index", "line 11", "'x'")),
    ({"piezo_index": [*range(9), "1e999"]}, ("piezo_index", "line 11", "'1e999'")),
    ({"piezo_index": [*range(9), "1_0"]}, ("piezo_index", "line 11", "'1_0'")),
    ({"piezo_index": [*range(9), 1e39]}, ("piezo_index", "beyond 1e+12")),
    ({"pinch": [0] * 4 + [1] * 5 + [0]}, ("pinch", "line 11")),
    ({"time_s": [0, 1, 2, 2, 4, 5, 6, 7, 8, 9]}, ("time_s", "jump")),
    ({"time_s": [i / 100 for i in range(10)]}, ("time_s", "100")),
    ({"time_s": [*(i / RATE for i in range(9)), "late"]}, ("time_s", "late")),
    ({"time_s": [i / RATE for i in range(5)] + [i / 9000 for i in range(5)]}, ("time_s", "9000")),
    ({"sample_rate_hz": [9000] * 10}, ("time_s", "sample_rate_hz", "9000")),
    ({"shore_a": [10] * 6 + [20] * 4}, ("shore_a", "line 7", "line 8")),
    ({"first_contact": [2] * 5 + [5] * 5}, ("first_contact", "outside")),
    ({"piezo_unit": ["furlong"] * 10}, ("piezo_unit", "furlong")),
    ({"force_index_0": [1] * 10}, ("force_index_1", "or none")),
    (
        {f"force_{f}_{k}": [0] * 9 + [200 * k] for f in ("index", "thumb") for k in range(6)},
        ("force", "'force_unit' to counts"),
    ),
    ({"pinch": list(range(10)), "first_contact": [0] * 10}, ("one sample",)),
]


@pytest.mark.parametrize(("changes", "words"), BAD_CSV)
def test_bad_csv_is_refused(tmp_path, refused, changes, words):
    refused(long_csv(tmp_path, **changes), "long.csv", *words)
