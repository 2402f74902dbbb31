"""Each invalid input gives one sentence and exit code 2, and leaves no files."""

import io
import os
import struct
import zipfile

import h5py
import numpy as np
import pytest
from import_files import LENGTH, RATE, SETTINGS, as_hdf5, imported, long_csv, npz, table
from import_files import wavs as wav_folder

nan = np.nan
PIEZO = np.random.default_rng(1).normal(size=(3, LENGTH, 1)).astype(np.float32)
hole = np.zeros((4, LENGTH, 2))
hole[2, 7, 1] = nan
BAD_ARRAYS = [
    ({"piezo": None}, ("piezo",)),
    ({"sample_rate_hz": None}, ("sample_rate_hz",)),
    ({"piezo_unit": None}, ("piezo_unit",)),
    ({"piezo": hole}, ("piezo", "(2, 7, 1)")),
    ({"piezo": np.full((4, LENGTH, 2), 1e300)}, ("piezo", "1e+12")),
    ({"piezo": np.full((4, LENGTH, 2), 2**40)}, ("piezo", "32 bits")),
    ({"piezo": np.zeros((4, LENGTH))}, ("piezo", "(4, 60)")),
    ({"piezo": np.zeros((0, LENGTH, 2))}, ("piezo", "empty")),
    ({"piezo": np.zeros((4, LENGTH, 2), complex)}, ("piezo", "complex")),
    ({"piezo": np.zeros((LENGTH, 4, 2)), "force": None}, ("piezo", "transpose")),
    ({"force": np.zeros((4, LENGTH, 12))}, ("force", "(4, 60, 12)")),
    ({"force": np.full((4, LENGTH, 2, 6), 300)}, ("'force_unit'", "bits")),
    (
        {"force": np.full((4, LENGTH, 2, 6), 65535), "force_unit": "counts"},
        ("'force_unit'", "65535"),
    ),
    ({"force_unit": "N"}, ("force_unit", "'N'")),
    ({"sample_rate_hz": 499}, ("sample_rate_hz", "499")),
    ({"sample_rate_hz": [RATE, RATE]}, ("sample_rate_hz",)),
    ({"sample_rate_hz": 5000 + 1j}, ("sample_rate_hz",)),
    ({"piezo_unit": "MV"}, ("piezo_unit", "MV")),
    ({"smoothing_alpha": 0.0}, ("smoothing_alpha",)),
    ({"source": "dream"}, ("source", "dream")),
    ({"session": np.array([1.0, nan, 1, 1])}, ("session", "pinch 1")),
    ({"object": np.array([0x110000] * 4, "<u4").view("<U1")}, ("object",)),
    ({"object": np.array([{"a": 1}] * 4, dtype=object)}, ("object",)),
]


@pytest.mark.parametrize(("changes", "words"), BAD_ARRAYS, ids=range(len(BAD_ARRAYS)))
def test_bad_arrays_are_refused(tmp_path, check_refused, changes, words):
    check_refused(npz(tmp_path, **changes), "pinches.npz", *words)


def npy(array):
    """Return an array as a member of an archive."""
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def declared(shape):
    """Return an array with a false shape."""
    old, new = b"'shape': (3, 60, 1), }", f"'shape': {shape}, }}".encode()
    grown = len(new) - len(old)
    return npy(PIEZO).replace(old + b" " * max(grown, 0), new + b" " * max(-grown, 0), 1)


def archive(path, piezo):
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in {"piezo": piezo, **{k: npy(v) for k, v in SETTINGS.items()}}.items():
            archive.writestr(f"{name}.npy", data)
    return path


@pytest.mark.parametrize(
    "member",
    [
        declared("(1000000000000, 60, 1)"),
        declared("(-3, -60, 1)"),
        declared("(0, 60, 1)"),
        b"hello",
        b"\x93NUMPY\7\0",
        npy(np.zeros((10, 60, 1), "S0")).replace(b"S1", b"S0"),
    ],
    ids=range(6),
)
def test_damaged_members_are_refused_by_name(tmp_path, check_refused, member):
    check_refused(archive(tmp_path / "x.npz", member), "x.npz", "piezo")


def test_archives_of_python_2_are_read(tmp_path):
    old = npy(PIEZO).replace(b"(3, 60, 1), } ", b"(3L, 60, 1), }")
    dataset = imported(archive(tmp_path / "x.npz", old), tmp_path / "out")
    assert np.array_equal(dataset[1].vibration(), PIEZO[1])


def test_a_damaged_npz_is_refused(tmp_path, check_refused):
    path = npz(tmp_path)
    for content in (path.read_bytes()[:300], b"", npy(np.zeros(3))):
        path.write_bytes(content)
        check_refused(path, "pinches.npz")


def test_bad_hdf5_is_refused(tmp_path, check_refused):
    path = tmp_path / "x.h5"
    path.write_bytes(b"not HDF5 at all")
    check_refused(path, "x.h5", "HDF5")
    with h5py.File(path, "w") as file:
        file.create_group("piezo")
    check_refused(path, "x.h5", "piezo")
    check_refused(as_hdf5(tmp_path, PIEZO, {"shore_a": [1, 2]}), "shore_a", "3 pinches")


@pytest.mark.parametrize(
    "add",
    [
        lambda file: file.update({"object": np.array([file.ref] * 3, dtype=h5py.ref_dtype)}),
        lambda file: file.update({"object": h5py.Empty("f4")}),
        lambda file: file.update({"object": np.zeros(3, [("a", "i4")])}),
        lambda file: file.create_dataset("object", data=["x" * 201] * 3, dtype=h5py.string_dtype()),
    ],
    ids=["references", "empty", "records", "long"],
)
def test_bad_hdf5_labels_are_refused_by_name(tmp_path, check_refused, add):
    with h5py.File(as_hdf5(tmp_path, PIEZO), "r+") as file:
        add(file)
    check_refused(tmp_path / "x.h5", "x.h5", "'object'")


@pytest.mark.parametrize("way", ["link", "external", "virtual"])
def test_hdf5_whose_data_lie_in_another_file_is_refused(tmp_path, check_refused, way):
    outside = tmp_path / "outside.h5"
    with h5py.File(outside, "w") as file:
        file["object"] = np.array([b"secret"] * 3)
    with h5py.File(as_hdf5(tmp_path, PIEZO), "r+") as file:
        if way == "link":
            file["object"] = h5py.ExternalLink(str(outside), "/object")
        elif way == "external":
            place = [(str(outside), 0, h5py.h5f.UNLIMITED)]
            file.create_dataset("object", (3,), "S10", external=place)
        else:
            layout = h5py.VirtualLayout((3,), "S10")
            layout[:] = h5py.VirtualSource(str(outside), "object", (3,))
            file.create_virtual_dataset("object", layout)
    check_refused(tmp_path / "x.h5", "x.h5", "'object'")


@pytest.mark.parametrize("name", ["x.npz", "x.h5", "x.csv", "x.mat", "x.wav"])
def test_pipe_is_refused_without_waiting(tmp_path, check_refused, name):
    os.mkfifo(tmp_path / name)
    check_refused(tmp_path / name, name)


BAD_TABLES = [
    ({"file": ["0.wav", "1.wav", "9.wav"]}, ("labels.csv", "'9.wav'")),
    ({"file": ["0.wav", "1.wav", "../2.wav"]}, ("labels.csv", "'../2.wav'")),
    ({"file": ["0.wav", "1.wav", "1.wav"]}, ("labels.csv", "'1.wav'")),
    ({"sample_rate_hz": [RATE, RATE, 16000]}, ("sample_rate_hz", "2.wav")),
    ({"shore_a": [10, "", 20]}, ("labels.csv", "shore_a", "line 3")),
    ({"hardness_class": ["soft", "harder", "hard"]}, ("hardness_class", "harder")),
    ({"pre_trigger_samples": [5, 5, 500]}, ("pre_trigger_samples", "500")),
    ({"material": ["a"] * 3, "object": ["a"] * 3}, ("'object'", "'material'")),
]


@pytest.mark.parametrize(("rows", "words"), BAD_TABLES)
def test_bad_tables_are_refused(tmp_path, check_refused, rows, words):
    check_refused(wav_folder(tmp_path, rows), *words)


def test_labels_that_do_not_match_the_files_are_refused(tmp_path, check_refused):
    folder = wav_folder(tmp_path)
    for content, word in (
        (b"file\n0.wav\n1.wav\n", "2.wav"),
        (b"name\n0.wav\n1.wav\n2.wav\n", "'file'"),
        (b"file\n", "no rows"),
        (b"file,shore_a\n0.wav\n", "line 2"),
        (b"file,file\n0.wav,1.wav\n", "twice"),
        (b"file\n\xff\xfe.wav\n", "UTF-8"),
    ):
        (folder / "labels.csv").write_bytes(content)
        check_refused(folder, "labels.csv", word)


def wav(channels=1, bits=16, rate=5000, data=bytes(200), kind=1):
    block = max(channels * bits // 8, 1) & 0xFFFF
    form = struct.pack("<HHIIHH", kind, channels, rate, rate * block, block, bits)
    body = (
        b"WAVEfmt " + struct.pack("<I", 16) + form + b"data" + struct.pack("<I", len(data)) + data
    )
    return b"RIFF" + struct.pack("<I", len(body)) + body


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (wav(channels=0), "a.wav"),
        (wav(channels=3, data=bytes(600)), "column 'channel'"),
        (wav(bits=64), "int64"),
        (wav(bits=0), "a.wav"),
        (wav(kind=3, bits=64, data=np.full(20, nan).tobytes()), "NaN"),
        (wav(kind=77), "a.wav"),
        (wav(rate=0), "sample rate"),
        (wav(rate=400), "400"),
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


BAD_CSV = [
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
    ({"force_index_0": [1] * 10}, ("force_index_1",)),
    (
        {f"force_{f}_{k}": [0] * 9 + [200 * k] for f in ("index", "thumb") for k in range(6)},
        ("'force_unit'", "bits"),
    ),
    ({"pinch": list(range(10)), "first_contact": [0] * 10}, ("one sample",)),
]


@pytest.mark.parametrize(("changes", "words"), BAD_CSV, ids=range(len(BAD_CSV)))
def test_bad_csv_is_refused(tmp_path, check_refused, changes, words):
    check_refused(long_csv(tmp_path, **changes), "long.csv", *words)


@pytest.mark.parametrize("cell", [b"x" * 140_000, b"\xff", b'"20', b"a," * 1_000_000])
def test_a_csv_that_cannot_be_read_is_refused(tmp_path, check_refused, cell):
    path = long_csv(tmp_path)
    path.write_bytes(path.read_bytes().replace(b"\n0,", b"\n" + cell + b",", 1))
    check_refused(path, "long.csv")
