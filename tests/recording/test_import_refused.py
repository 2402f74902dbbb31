"""Each invalid input gives one sentence and exit code 2, and leaves no files."""

from __future__ import annotations

import struct
from typing import Any

import h5py
import numpy as np
import pytest
from import_files import LENGTH, RATE, arrays, long_csv, npz, table, wavs

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
    ({"sample_rate_hz": np.array([RATE, RATE])}, ("sample_rate_hz", "single value")),
    ({"piezo_unit": np.array("mV")}, ("piezo_unit", "mV")),
    ({"smoothing_alpha": np.array(0.0)}, ("smoothing_alpha",)),
    ({"source": np.array("dream")}, ("source", "dream")),
    ({"session": np.array([1.0, nan, 1, 1])}, ("session", "pinch 1")),
]


@pytest.mark.parametrize(("changes", "words"), BAD_ARRAYS)
def test_bad_arrays_are_refused(tmp_path, check_refused, changes, words):
    check_refused(npz(tmp_path, **changes), "pinches.npz", *words)


def test_bad_hdf5_is_refused(tmp_path, check_refused):
    path = tmp_path / "p.h5"
    path.write_bytes(b"not HDF5 at all")
    check_refused(path, "p.h5", "HDF5")
    with h5py.File(path, "w") as file:
        file.create_group("piezo")
    check_refused(path, "p.h5", "piezo")
    with h5py.File(path, "w") as file:
        for name, values in arrays(shore_a=np.zeros(3)).items():
            if values.ndim:
                file[name] = values.astype("S") if values.dtype.kind == "U" else values
        file.attrs.update(sample_rate_hz=RATE, piezo_unit="V")
    check_refused(path, "shore_a", "4 pinches")


def test_a_damaged_npz_is_refused(tmp_path, check_refused):
    path = npz(tmp_path)
    path.write_bytes(path.read_bytes()[:300])
    check_refused(path, "pinches.npz")
    path.write_bytes(b"")
    check_refused(path, "pinches.npz")
    with path.open("wb") as stream:
        np.save(stream, np.zeros(3))
    check_refused(path, "pinches.npz")


BAD_TABLES: list[tuple[dict[str, list[Any]], tuple[str, ...]]] = [
    ({"file": ["0.wav", "1.wav", "9.wav"]}, ("labels.csv", "'9.wav'", "not in the folder")),
    ({"file": ["0.wav", "1.wav", "../2.wav"]}, ("labels.csv", "'../2.wav'")),
    ({"file": ["0.wav", "1.wav", "1.wav"]}, ("labels.csv", "two rows")),
    ({"sample_rate_hz": [RATE, RATE, 16000]}, ("sample_rate_hz", "2.wav", "5000")),
    ({"shore_a": [10, "", 20]}, ("labels.csv", "shore_a", "line 3")),
    ({"hardness_class": ["soft", "harder", "hard"]}, ("hardness_class", "harder")),
    ({"pre_trigger_samples": [5, 5, 500]}, ("pre_trigger_samples", "500")),
    ({"material": ["a"] * 3, "object": ["a"] * 3}, ("keep one",)),
]


@pytest.mark.parametrize(("rows", "words"), BAD_TABLES)
def test_bad_tables_are_refused(tmp_path, check_refused, rows, words):
    check_refused(wavs(tmp_path, rows), *words)


def test_labels_that_do_not_match_the_files_are_refused(tmp_path, check_refused):
    folder = wavs(tmp_path)
    table(folder / "labels.csv", {"file": ["0.wav", "1.wav"]})
    check_refused(folder, "labels.csv", "no row for 1 .wav file", "2.wav")
    table(folder / "labels.csv", {"name": ["0.wav", "1.wav", "2.wav"]})
    check_refused(folder, "labels.csv", "file")
    table(folder / "labels.csv", {"file": []})
    check_refused(folder, "labels.csv", "no rows")
    (folder / "labels.csv").write_bytes(b"file,shore_a\n0.wav\n")
    check_refused(folder, "labels.csv", "line 2")
    (folder / "labels.csv").write_bytes(b"file,file\n0.wav,1.wav\n")
    check_refused(folder, "labels.csv", "twice")
    (folder / "labels.csv").write_bytes(b"file\n\xff\xfe.wav\n")
    check_refused(folder, "labels.csv", "UTF-8")


def wav(
    channels: int = 1,
    bits: int = 16,
    rate: int = 5000,
    data: bytes = bytes(200),
    kind: int = 1,
    declared: int | None = None,
) -> bytes:
    block = max(channels * bits // 8, 1)
    block &= 0xFFFF
    form = struct.pack("<HHIIHH", kind, channels, rate, rate * block, block, bits)
    size = len(data) if declared is None else declared
    body = b"WAVEfmt " + struct.pack("<I", 16) + form + b"data" + struct.pack("<I", size) + data
    return b"RIFF" + struct.pack("<I", len(body)) + body


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (wav(channels=0), "a.wav"),
        (wav(channels=3, data=bytes(600)), "column 'channel'"),
        (wav(bits=64), "int64"),
        (wav(bits=0), "a.wav"),
        (wav(kind=3, bits=64, data=np.full(20, np.nan).tobytes()), "NaN"),
        (wav(kind=77), "a.wav"),
        (wav(rate=0), "sample rate"),
        (wav(rate=1000), "1000"),
        (wav(declared=0xFFFFFFFF), "holds 200"),
        (wav()[:-50], "holds 150"),
        (wav()[:20], "a.wav"),
        (b"RIFF\0\0\0\0WAVE", "a.wav"),
        (b"", "a.wav"),
    ],
)
def test_invalid_wav_is_refused(tmp_path, check_refused, content, word):
    table(tmp_path / "labels.csv", {"file": ["a.wav"]})
    (tmp_path / "a.wav").write_bytes(content)
    check_refused(tmp_path, word)


def test_files_in_different_forms_are_refused(tmp_path, check_refused):
    table(tmp_path / "labels.csv", {"file": ["a.wav", "b.wav"]})
    (tmp_path / "a.wav").write_bytes(wav())
    for form in (wav(rate=8000), wav(bits=8), wav(channels=2)):
        (tmp_path / "b.wav").write_bytes(form)
        check_refused(tmp_path, "b.wav", "a.wav")


BAD_CSV: list[tuple[dict[str, Any], tuple[str, ...]]] = [
    ({"pinch": None}, ("column 'pinch'",)),
    ({"piezo_index": None}, ("column 'piezo_index'",)),
    ({"time_s": None}, ("rate", "--rate")),
    ({"piezo_index": [*range(9), "x"]}, ("piezo_index", "line 11", "'x'")),
    ({"piezo_index": [*range(9), "9" * 5000]}, ("piezo_index",)),
    ({"shore_a": ["\x1b[31m" + "9" * 4000] * 10}, ("'shore_a' of line 2",)),
    ({"piezo_index": [*range(9), "1_0"]}, ("piezo_index", "line 11", "'1_0'")),
    ({"pinch": [0] * 4 + [1] * 5 + [0]}, ("pinch", "line 11")),
    ({"time_s": [0, 1, 2, 2, 4, 5, 6, 7, 8, 9]}, ("time_s", "jump")),
    ({"time_s": [i / 100 for i in range(10)]}, ("time_s", "100")),
    ({"time_s": [i / RATE for i in range(5)] + [i / 9000 for i in range(5)]}, ("time_s", "9000")),
    ({"sample_rate_hz": [9000] * 10}, ("time_s", "sample_rate_hz", "9000")),
    ({"shore_a": [10] * 6 + [20] * 4}, ("shore_a", "line 7", "line 8")),
    ({"piezo_unit": ["furlong"] * 10}, ("piezo_unit", "furlong")),
    ({"force_index_0": [1] * 10}, ("force_index_1", "or none")),
    (
        {f"force_{f}_{k}": [0] * 9 + [200 * k] for f in ("index", "thumb") for k in range(6)},
        ("force", "'force_unit' to counts"),
    ),
    ({"pinch": list(range(10)), "first_contact": [0] * 10}, ("one sample",)),
]


@pytest.mark.parametrize(("changes", "words"), BAD_CSV)
def test_bad_csv_is_refused(tmp_path, check_refused, changes, words):
    check_refused(long_csv(tmp_path, **changes), "long.csv", *words)


@pytest.mark.parametrize(
    ("cell", "word"), [(b"x" * 140_000, "CSV"), (b"\xff", "UTF-8"), (b'"20', "CSV")]
)
def test_a_csv_that_cannot_be_read_is_refused(tmp_path, check_refused, cell, word):
    path = long_csv(tmp_path)
    path.write_bytes(path.read_bytes().replace(b"\n0,", b"\n" + cell + b",", 1))
    check_refused(path, word)


def test_header_of_a_million_columns_is_refused(tmp_path, check_refused):
    path = tmp_path / "x.csv"
    path.write_text("a," * 1_000_000 + "\n")
    check_refused(path, "x.csv")
