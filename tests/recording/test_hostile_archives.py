"""NPZ and HDF5 files that declare false sizes or link to other files."""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from firstcontact.cli.main import main
from firstcontact.recording import import_path

PIEZO = np.random.default_rng(1).normal(size=(3, 60, 1)).astype(np.float32)
SECRET = "root:x:0:0"


@pytest.fixture
def check_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Return a function that runs ``import`` and asserts a refusal.

    The refusal must be one short sentence with the given words, and nothing may be written.
    """

    def check(path: Path, *words: str) -> str:
        assert main(["import", str(path), "--out", str(tmp_path / "out")]) == 2
        message = capsys.readouterr().err
        assert message.count("\n") == 1
        assert len(message) < 1000
        assert SECRET not in message
        for word in (path.name, *words):
            assert word in message, message
        assert not (tmp_path / "out").exists()
        return message

    return check


# --- NPZ -----------------------------------------------------------------------------------


def npy(array: np.ndarray) -> bytes:
    """Return an array as a member of an archive."""
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def npz(path: Path, method: int = zipfile.ZIP_STORED, **members: bytes) -> Path:
    usual = {
        "piezo": npy(PIEZO),
        "sample_rate_hz": npy(np.array(5000)),
        "piezo_unit": npy(np.array("V")),
        **members,
    }
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, data in usual.items():
            archive.writestr(f"{name}.npy", data)
    return path


def test_archive_of_these_tests_is_valid(tmp_path: Path) -> None:
    dataset = import_path(npz(tmp_path / "x.npz"), tmp_path / "out")
    assert np.array_equal(dataset.pinches[1].vibration(), PIEZO[1])


def test_python_2_header_prints_no_warning(tmp_path):
    old = npy(PIEZO).replace(b"(3, 60, 1), } ", b"(3L, 60, 1), }")
    path = npz(tmp_path / "x.npz", piezo=old)
    # Warnings are errors in tests: there is none.
    assert np.array_equal(import_path(path, tmp_path / "out").pinches[1].vibration(), PIEZO[1])


def test_invalid_characters_are_refused(tmp_path, check_refused):
    objects = np.array([0x110000, 97, 97], "<u4").view("<U1")
    check_refused(npz(tmp_path / "x.npz", object=npy(objects)), "object")


def test_a_complex_rate_is_refused(tmp_path, check_refused):
    check_refused(
        npz(tmp_path / "x.npz", sample_rate_hz=npy(np.array(5000 + 1j))), "'sample_rate_hz' is"
    )


def test_shape_larger_than_the_data_is_refused(tmp_path, check_refused):
    header = npy(PIEZO)
    for shape in ("(1000000000000, 60, 1)", "(-3, -60, 1)", "(0, 60, 1)"):
        old = b"'shape': (3, 60, 1), }"
        new = f"'shape': {shape}, }}".encode()
        grown = len(new) - len(old)
        data = header.replace(old + b" " * max(grown, 0), new + b" " * max(-grown, 0), 1)
        assert len(data) == len(header)
        check_refused(npz(tmp_path / "x.npz", piezo=data), "piezo", "declares the shape")


def test_an_encrypted_member_is_refused(tmp_path, check_refused):
    path = npz(tmp_path / "x.npz")
    data = bytearray(path.read_bytes())
    for signature, flags in ((b"PK\3\4", 6), (b"PK\1\2", 8)):
        data[data.index(signature) + flags] |= 1
    path.write_bytes(data)
    check_refused(path, "'piezo' is encrypted")


def test_an_unknown_compression_is_refused(tmp_path, check_refused):
    path = npz(tmp_path / "x.npz")
    data = bytearray(path.read_bytes())
    for signature, method in ((b"PK\3\4", 8), (b"PK\1\2", 10)):
        data[data.index(signature) + method] = 99
    path.write_bytes(data)
    check_refused(path, "piezo")


@pytest.mark.parametrize("data", [b"", b"hello", b"\x93NUMPY", b"\x93NUMPY\7\0", b"PK\3\4" * 50])
def test_member_that_is_not_an_array_is_refused(tmp_path, check_refused, data):
    check_refused(npz(tmp_path / "x.npz", piezo=data), "'piezo' is not a NumPy array")


def test_objects_are_refused_and_not_loaded(tmp_path, check_refused):
    path = tmp_path / "x.npz"
    np.savez(path, piezo=np.array([{"a": 1}], dtype=object))
    check_refused(path, "'piezo' holds Python objects")


def test_archive_larger_than_memory_is_refused(tmp_path, check_refused):
    zeros = npy(np.zeros(25_000_000, np.float32))
    path = npz(tmp_path / "x.npz", zipfile.ZIP_DEFLATED, piezo=zeros)
    assert path.stat().st_size < 200_000
    check_refused(path, "declares", "64 MiB")


def test_unused_members_are_not_unpacked(tmp_path):
    path = npz(tmp_path / "x.npz", zipfile.ZIP_DEFLATED, other=bytes(100_000_000), bad=b"?")
    notes = import_path(path, tmp_path / "out").notes
    assert any("bad, other" in note for note in notes)


@pytest.mark.parametrize("name", ["x.npz", "x.h5", "x.csv"])
def test_pipe_is_refused_without_waiting(tmp_path, check_refused, name):
    os.mkfifo(tmp_path / name)
    check_refused(tmp_path / name, "not a regular file")


# --- HDF5 ----------------------------------------------------------------------------------


def hdf5(path: Path, fill: Callable[[h5py.File], object] = lambda file: None) -> Path:
    with h5py.File(path, "w") as file:
        file["piezo"] = PIEZO
        file.attrs.update({"sample_rate_hz": 5000, "piezo_unit": "V"})
        fill(file)
    return path


@pytest.fixture
def outside(tmp_path: Path) -> Path:
    """Write another HDF5 file, with private content."""
    path = tmp_path / "outside.h5"
    with h5py.File(path, "w") as file:
        file["object"] = np.array([SECRET.encode()] * 3)
        file["group/object"] = file["object"][()]
    return path


def test_an_external_link_is_not_followed(tmp_path, check_refused, outside):
    def fill(file):
        file["object"] = h5py.ExternalLink(str(outside), "/object")

    check_refused(hdf5(tmp_path / "x.h5", fill), "'object' is a link")


def test_a_soft_link_through_an_external_one_is_not_followed(tmp_path, check_refused, outside):
    def fill(file):
        file["more/out"] = h5py.ExternalLink(str(outside), "/group")
        file["object"] = h5py.SoftLink("more/out/object")

    check_refused(hdf5(tmp_path / "x.h5", fill), "'object' is a link")


@pytest.mark.parametrize("to", ["/nowhere", "session", "/piezo/further", "/loop"])
def test_a_link_to_nowhere_is_refused_by_name(tmp_path, check_refused, to):
    def fill(file):
        file["session"] = h5py.SoftLink(to)
        file["loop"] = h5py.SoftLink("/loop")

    check_refused(hdf5(tmp_path / "x.h5", fill), "'session' is a link")


def test_soft_links_within_the_file_are_followed(tmp_path):
    def fill(file):
        file["kept/names"] = np.array([b"a", b"b", b"c"])
        file["kept/deep"] = h5py.SoftLink("names")
        file["specimen"] = h5py.SoftLink("/kept/./deep")

    dataset = import_path(hdf5(tmp_path / "x.h5", fill), tmp_path / "out")
    assert dataset.specimens.tolist() == ["a", "b", "c"]


def test_external_storage_is_not_read(tmp_path, check_refused):
    (tmp_path / "passwd").write_text(SECRET * 10)

    def fill(file):
        file.create_dataset(
            "object", (3,), "S10", external=[(str(tmp_path / "passwd"), 0, h5py.h5f.UNLIMITED)]
        )

    check_refused(hdf5(tmp_path / "x.h5", fill), "'object' is stored outside")


def test_a_virtual_dataset_is_not_read(tmp_path, check_refused, outside):
    def fill(file):
        layout = h5py.VirtualLayout((3,), "S10")
        layout[:] = h5py.VirtualSource(str(outside), "object", (3,))
        file.create_virtual_dataset("object", layout)

    check_refused(hdf5(tmp_path / "x.h5", fill), "'object' is stored outside")


@pytest.mark.parametrize("more", [{}, {"chunks": (1, 1000, 1), "compression": "gzip"}])
def test_dataset_larger_than_memory_is_refused(tmp_path, check_refused, more):
    def fill(file):
        del file["piezo"]
        file.create_dataset("piezo", (10**6, 10**6, 1), "f4", **more)

    check_refused(hdf5(tmp_path / "x.h5", fill), "declares")


def test_repeated_long_text_is_refused(tmp_path, check_refused):
    def fill(file):
        file.create_dataset("object", data=["x" * 100_000] * 3, dtype=h5py.string_dtype())

    check_refused(hdf5(tmp_path / "x.h5", fill), "'object' has a text of 100000 bytes")


def test_other_types_are_refused_by_name(tmp_path, check_refused):
    def references(file):
        file["object"] = np.array([file.ref] * 3, dtype=h5py.ref_dtype)

    check_refused(hdf5(tmp_path / "x.h5", references), "'object' holds neither")
    check_refused(
        hdf5(tmp_path / "y.h5", lambda f: f.update({"object": h5py.Empty("f4")})), "is empty"
    )
    records = np.zeros(3, [("a", "i4")])
    check_refused(
        hdf5(tmp_path / "z.h5", lambda f: f.update({"object": records})), "neither a text nor"
    )


def test_texts_of_any_layout_are_read(tmp_path):
    def fill(file):
        file.create_dataset("object", data=["Äpfel", "b", "c"], dtype=h5py.string_dtype())
        file["session"] = np.array([b"1", b"2", b"2"])

    dataset = import_path(hdf5(tmp_path / "x.h5", fill), tmp_path / "out")
    assert dataset.objects.tolist() == ["Äpfel", "b", "c"]
    assert dataset.sessions.tolist() == ["1", "2", "2"]
