"""WAV folders and CSV tables with invalid content."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest


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


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    path = tmp_path / "wavs"
    path.mkdir()
    (path / "labels.csv").write_text("file\na.wav\n")
    return path


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (wav(channels=0), "a.wav"),
        (wav(channels=3, data=bytes(600)), "3 channels"),
        (wav(channels=65535, data=bytes(200)), "a.wav"),
        (wav(bits=64), "int64"),
        (wav(bits=0), "a.wav"),
        (wav(kind=3, bits=64, data=np.full(20, np.nan).tobytes()), "NaN"),
        (wav(kind=77), "a.wav"),
        (wav(rate=0), "sample rate"),
        (wav(data=b""), "a.wav"),
        (wav(declared=0xFFFFFFFF), "holds 200"),
        (wav()[:-50], "holds 150"),
        (wav()[:36], "a.wav"),
        (wav()[:20], "a.wav"),
        (b"RIFF\0\0\0\0WAVE", "a.wav"),
        (b"RF64" + wav()[4:], "a.wav"),
        (b"", "a.wav"),
    ],
)
def test_invalid_wav_is_refused(folder, check_refused, content, word):
    (folder / "a.wav").write_bytes(content)
    check_refused(folder, word)


def test_files_in_different_forms_are_refused(folder, check_refused):
    (folder / "labels.csv").write_text("file\na.wav\nb.wav\n")
    (folder / "a.wav").write_bytes(wav())
    for other in (wav(rate=8000), wav(bits=8), wav(channels=2)):
        (folder / "b.wav").write_bytes(other)
        check_refused(folder, "b.wav", "a.wav")


ROWS = [[k // 5, k % 5, 20, 2] for k in range(10)]


def table(path: Path, **changes: object) -> Path:
    """Write a table of ten rows, with these cells in the first row."""
    names = ["pinch", "piezo_index", "shore_a", "first_contact"]
    lines = [",".join(names)]
    for k, row in enumerate(ROWS):
        cells = dict(zip(names, map(str, row), strict=True))
        if k < 5:
            cells |= {name: str(value) for name, value in changes.items()}
        lines.append(",".join(cells.values()))
    path.write_text("\n".join(lines), encoding="utf-8", errors="surrogateescape")
    return path


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"piezo_index": "9" * 5000}, "piezo_index"),
        ({"piezo_index": "1e999"}, "piezo_index"),
        ({"piezo_index": "-inf"}, "piezo_index"),
        ({"shore_a": "9" * 400}, "shore_a"),
        ({"shore_a": "1e400"}, "shore_a"),
        ({"shore_a": "\x1b[31m" + "9" * 4000}, "'shore_a' of line 2"),
        ({"first_contact": "9" * 300}, "first_contact"),
        ({"first_contact": "inf"}, "first_contact"),
        ({"pinch": "x" * 140_000}, "CSV"),
        ({"pinch": "\udcff"}, "UTF-8"),
        ({"shore_a": '"20'}, "CSV"),
    ],
)
def test_cells_out_of_bounds_are_refused(tmp_path, check_refused, changes, word):
    check_refused(table(tmp_path / "x.csv", **changes), word, rate=5000)


def test_header_of_a_million_columns_is_refused(tmp_path, check_refused):
    path = tmp_path / "x.csv"
    path.write_text("a," * 1_000_000 + "\n")
    check_refused(path, "x.csv")
