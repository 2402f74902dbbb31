"""Valid files of every format that `import` reads. Tests change one property of them."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import wavfile

from firstcontact.cli.main import main
from firstcontact.core import Dataset
from firstcontact.recording import load_dataset

RATE = 5000
LENGTH = 60


def imported(path: Path, out: Path, *more: str) -> Dataset:
    assert main(["import", str(path), "--out", str(out), *more]) == 0
    return load_dataset(out)


def arrays(**changes: Any) -> dict[str, Any]:
    """Return four pinches as arrays that can be imported. A change to None omits an array."""
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
    """Write a folder of three WAV files with their table."""
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
    """Write a CSV with two pinches of five samples, one row per sample."""
    columns: dict[str, Any] = {
        "pinch": [0] * 5 + [1] * 5,
        "piezo_index": list(range(10)),
        "time_s": [round(i / RATE, 6) for i in range(10)],
        "shore_a": [10] * 5 + [20] * 5,
        "first_contact": [2] * 5 + [3] * 5,
        **changes,
    }
    return table(folder / "long.csv", {k: v for k, v in columns.items() if v is not None})
