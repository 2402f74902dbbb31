"""NPZ and HDF5 files that declare false sizes or link to other files."""

from __future__ import annotations

import io
import os
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from firstcontact.core import InputError
from firstcontact.recording import import_path

PIEZO = np.random.default_rng(1).normal(size=(3, 60, 1)).astype(np.float32)
SECRET = "root:x:0:0"
Check = Callable[..., None]


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
    python_2 = npy(PIEZO).replace(b"(3, 60, 1), } ", b"(3L, 60, 1), }")
    for number, data in enumerate((npy(PIEZO), python_2)):
        # Warnings are errors in tests: there is none.
        dataset = import_path(npz(tmp_path / "x.npz", piezo=data), tmp_path / f"{number}")
        assert np.array_equal(dataset.pinches[1].vibration(), PIEZO[1])


def declared(shape: str) -> bytes:
    """Return an array with a false shape."""
    old, new = b"'shape': (3, 60, 1), }", f"'shape': {shape}, }}".encode()
    grown = len(new) - len(old)
    return npy(PIEZO).replace(old + b" " * max(grown, 0), new + b" " * max(-grown, 0), 1)


@pytest.mark.parametrize(
    "members",
    [
        {"object": npy(np.array([0x110000, 97, 97], "<u4").view("<U1"))},
        {"sample_rate_hz": npy(np.array(5000 + 1j))},
        {"piezo": declared("(1000000000000, 60, 1)")},
        {"piezo": declared("(-3, -60, 1)")},
        {"piezo": declared("(0, 60, 1)")},
        {"piezo": b"hello"},
        {"piezo": b"\x93NUMPY\7\0"},
        {"piezo": npy(np.array([{"a": 1}], dtype=object))},
        {"piezo": npy(np.zeros((100_000, 60, 1), "S0")).replace(b"S1", b"S0")},
    ],
    ids=range(9),
)
def test_invalid_members_are_refused_by_name(
    tmp_path: Path, check_refused: Check, members: dict[str, bytes]
) -> None:
    check_refused(npz(tmp_path / "x.npz", **members), "x.npz", *members)


def test_archive_larger_than_memory_is_refused(tmp_path: Path, check_refused: Check) -> None:
    zeros = npy(np.zeros(25_000_000, np.float32))
    path = npz(tmp_path / "x.npz", zipfile.ZIP_DEFLATED, piezo=zeros)
    assert path.stat().st_size < 200_000
    check_refused(path, "declares", "64 MiB")


def test_second_member_of_a_name_is_not_unpacked(tmp_path: Path) -> None:
    path = npz(tmp_path / "x.npz")
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        small = archive.filelist.pop(0)
        archive.writestr("piezo", npy(np.zeros((3, 10_000_000, 1), np.float32)))
        archive.filelist.append(small)  # the directory names it last
    dataset = import_path(path, tmp_path / "out")
    assert np.array_equal(dataset.pinches[1].vibration(), PIEZO[1])


def test_unused_members_are_not_unpacked(tmp_path: Path) -> None:
    path = npz(tmp_path / "x.npz", zipfile.ZIP_DEFLATED, other=bytes(100_000_000), bad=b"?")
    notes = import_path(path, tmp_path / "out").notes
    assert any("bad, other" in note for note in notes)


@pytest.mark.parametrize("name", ["x.npz", "x.h5", "x.csv", "x.mat", "x.wav"])
def test_pipe_is_refused_without_waiting(tmp_path: Path, check_refused: Check, name: str) -> None:
    os.mkfifo(tmp_path / name)
    check_refused(tmp_path / name, name, "not a regular file")


def hdf5(path: Path, fill: Callable[[h5py.File], object] = lambda file: None) -> Path:
    with h5py.File(path, "w") as file:
        file["piezo"] = PIEZO
        file.attrs.update({"sample_rate_hz": 5000, "piezo_unit": "V"})
        fill(file)
    return path


def fill_link(file: h5py.File, outside: Path) -> None:
    file["object"] = h5py.ExternalLink(str(outside), "/object")


def fill_loop(file: h5py.File, outside: Path) -> None:
    file["object"] = h5py.SoftLink("/object")


def fill_external(file: h5py.File, outside: Path) -> None:
    file.create_dataset("object", (3,), "S10", external=[(str(outside), 0, h5py.h5f.UNLIMITED)])


def fill_virtual(file: h5py.File, outside: Path) -> None:
    layout = h5py.VirtualLayout((3,), "S10")
    layout[:] = h5py.VirtualSource(str(outside), "object", (3,))
    file.create_virtual_dataset("object", layout)


def fill_long_text(file: h5py.File, outside: Path) -> None:
    file.create_dataset("object", data=["x" * 100_000] * 3, dtype=h5py.string_dtype())


def fill_references(file: h5py.File, outside: Path) -> None:
    file["object"] = np.array([file.ref] * 3, dtype=h5py.ref_dtype)


def fill_nothing(file: h5py.File, outside: Path) -> None:
    file["object"] = h5py.Empty("f4")


def fill_records(file: h5py.File, outside: Path) -> None:
    file["object"] = np.zeros(3, [("a", "i4")])


FILLS = [
    fill_link, fill_loop, fill_external, fill_virtual, fill_long_text,
    fill_references, fill_nothing, fill_records,
]  # fmt: skip


@pytest.mark.parametrize("fill", FILLS)
def test_nothing_but_small_arrays_of_the_file_is_read(
    tmp_path: Path, check_refused: Check, fill: Callable[[h5py.File, Path], None]
) -> None:
    outside = tmp_path / "outside.h5"
    with h5py.File(outside, "w") as file:
        file["object"] = np.array([SECRET.encode()] * 3)
    check_refused(hdf5(tmp_path / "x.h5", lambda file: fill(file, outside)), "x.h5", "'object'")


@pytest.mark.parametrize("more", [{}, {"chunks": (1, 1000, 1), "compression": "gzip"}])
def test_dataset_larger_than_memory_is_refused(
    tmp_path: Path, check_refused: Check, more: dict[str, Any]
) -> None:
    def fill(file: h5py.File) -> None:
        del file["piezo"]
        file.create_dataset("piezo", (10**6, 10**6, 1), "f4", **more)

    check_refused(hdf5(tmp_path / "x.h5", fill), "declares")


def test_texts_of_any_layout_are_read(tmp_path: Path) -> None:
    def fill(file: h5py.File) -> None:
        file.create_dataset("object", data=["Äpfel", "b", "c"], dtype=h5py.string_dtype())
        file["session"] = np.array([b"1", b"2", b"2"])

    dataset = import_path(hdf5(tmp_path / "x.h5", fill), tmp_path / "out")
    assert dataset.objects.tolist() == ["Äpfel", "b", "c"]
    assert dataset.sessions.tolist() == ["1", "2", "2"]


def test_texts_that_share_one_place_are_not_all_read(tmp_path: Path) -> None:
    def fill(file: h5py.File) -> None:
        nonlocal place
        texts = file.create_dataset("object", (200,), h5py.string_dtype())
        texts[:] = ["x" * 2_000_000, *["y"] * 199]
        place = texts.id.get_offset()

    place = 0
    path = hdf5(tmp_path / "shared.h5", fill)
    content = bytearray(path.read_bytes())
    content[place : place + 200 * 16] = content[place : place + 16] * 200
    path.write_bytes(content)
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match="text of 2000000 bytes"):
            import_path(path, tmp_path / "out", source="real")
        assert tracemalloc.get_traced_memory()[1] < 200e6
    finally:
        tracemalloc.stop()
