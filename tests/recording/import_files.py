"""Valid files of every format that `import` reads. Tests change one property of them."""

import csv
from typing import Any

import h5py
import numpy as np
from scipy.io import wavfile

from firstcontact.cli.main import main
from firstcontact.recording import load_dataset

RATE = 5000
LENGTH = 60
SETTINGS = {"sample_rate_hz": RATE, "piezo_unit": "V"}


def imported(path, out, *more):
    assert main(["import", str(path), "--out", str(out), *more]) == 0
    return load_dataset(out)


def arrays(**changes):
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
        **{name: np.array(value) for name, value in SETTINGS.items()},
        **changes,
    }
    return {name: value for name, value in made.items() if value is not None}


def npz(folder, **changes):
    np.savez(folder / "pinches.npz", **arrays(**changes))
    return folder / "pinches.npz"


def table(path, columns):
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
    return path


def wavs(folder, rows=None, dtype="int16"):
    """Write a folder of three WAV files with their table."""
    folder = folder / "wavs"
    (folder / "wav").mkdir(parents=True)
    for i in range(3):
        wavfile.write(folder / "wav" / f"{i}.wav", RATE, np.arange(LENGTH + i).astype(dtype))
    table(folder / "labels.csv", {"file": ["0.wav", "1.wav", "2.wav"], **(rows or {})})
    return folder


def long_csv(folder, **changes):
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


# Files of the same piezo signals, shape (pinches, samples, fingers), and the same labels.


def as_npz(folder, values, labels=(), **settings):
    np.savez(folder / "x.npz", piezo=values, **{**SETTINGS, **settings, **dict(labels)})
    return folder / "x.npz"


def as_hdf5(folder, values, labels=(), **settings):
    with h5py.File(folder / "x.h5", "w") as file:
        file.update({"piezo": values, **dict(labels)})
        file.attrs.update({**SETTINGS, **settings})
    return folder / "x.h5"


def as_wavs(folder, values, labels=(), **settings):
    (folder / "wavs").mkdir()
    names = [f"{i}.wav" for i in range(len(values))]
    for name, pinch in zip(names, values, strict=True):
        wavfile.write(folder / "wavs" / name, RATE, pinch)
    same = {name: [value] * len(values) for name, value in settings.items()}
    table(folder / "wavs" / "labels.csv", {"file": names, **dict(labels), **same})
    return folder / "wavs"


def as_csv(folder, values, labels=(), **settings):
    n, samples, fingers = values.shape
    columns = {"pinch": np.repeat(range(n), samples), "time_s": [*np.arange(samples) / RATE] * n}
    names = ("piezo_index", "piezo_thumb")[:fingers]
    columns |= {name: values[..., k].ravel().astype(float) for k, name in enumerate(names)}
    columns |= {name: np.repeat(column, samples) for name, column in dict(labels).items()}
    columns |= {name: [value] * (n * samples) for name, value in settings.items()}
    return table(folder / "x.csv", {name: list(column) for name, column in columns.items()})


MAKERS = [as_npz, as_hdf5, as_wavs, as_csv]
