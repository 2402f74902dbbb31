"""Motor start in imports, exports and resampling of every kind of file."""

from __future__ import annotations

import csv
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import wavfile

from firstcontact.core import Dataset, InputError
from firstcontact.recording import EXPORTERS, export, import_path, load_dataset
from firstcontact.signal import resample_dataset

RATE = 5000
STARTS = [12, -1, 30]
CONTACTS = [40, 41, -1]
SAMPLES = 80


def arrays() -> dict[str, np.ndarray]:
    piezo = np.random.default_rng(1).normal(size=(3, SAMPLES, 1)).astype(np.float32)
    return {"piezo": piezo, "first_contact": np.array(CONTACTS), "motor_start": np.array(STARTS)}


def npz(folder: Path) -> Path:
    np.savez(folder / "x.npz", **arrays(), sample_rate_hz=RATE, piezo_unit="V")
    return folder / "x.npz"


def hdf5(folder: Path) -> Path:
    with h5py.File(folder / "x.h5", "w") as file:
        file.update(arrays())
        file.attrs.update({"sample_rate_hz": RATE, "piezo_unit": "V"})
    return folder / "x.h5"


def wav(folder: Path) -> Path:
    (folder / "wavs").mkdir()
    rows = [["file", "first_contact", "motor_start"]]
    for i, data in enumerate(arrays()["piezo"]):
        wavfile.write(folder / "wavs" / f"{i}.wav", RATE, data)
        rows.append([f"{i}.wav", str(CONTACTS[i]), str(STARTS[i])])
    with (folder / "wavs" / "labels.csv").open("w", newline="") as stream:
        csv.writer(stream).writerows(rows)
    return folder / "wavs"


def long_csv(folder: Path) -> Path:
    rows: list[list[object]] = [["pinch", "piezo_index", "first_contact", "motor_start"]]
    for i, data in enumerate(arrays()["piezo"]):
        rows += [[i, float(v), CONTACTS[i], STARTS[i]] for v in data[:, 0]]
    with (folder / "x.csv").open("w", newline="") as stream:
        csv.writer(stream).writerows(rows)
    return folder / "x.csv"


def starts(dataset: Dataset) -> list[int]:
    return [
        -1 if p.motor_start is None else p.motor_start - p.first_sample for p in dataset.pinches
    ]


@pytest.mark.parametrize("make", [npz, hdf5, wav, long_csv])
def test_motor_start_is_imported_from_every_kind_of_file(tmp_path, make):
    rate = RATE if make is long_csv else None
    import_path(make(tmp_path), tmp_path / "out", rate)
    dataset = load_dataset(tmp_path / "out")
    assert starts(dataset) == STARTS
    assert dataset.pinches[2].motor_start == 2 * (SAMPLES + 1) + 30


@pytest.mark.parametrize(("to", "name"), [("hdf5", "y.h5"), ("csv", "y.csv")])
def test_motor_start_round_trips_through_exports(tmp_path, to, name):
    import_path(npz(tmp_path), tmp_path / "out")
    export(load_dataset(tmp_path / "out"), EXPORTERS[to], tmp_path / name)
    assert starts(import_path(tmp_path / name, tmp_path / "back")) == STARTS


def test_motor_start_is_resampled(tmp_path):
    import_path(npz(tmp_path), tmp_path / "out")
    assert starts(resample_dataset(load_dataset(tmp_path / "out"), 2 * RATE)) == [24, -1, 60]


@pytest.mark.parametrize(("start", "place"), [(40, "40 samples"), (-2, "40 samples")])
def test_motor_start_outside_the_pinch_is_refused(tmp_path, start, place):
    content = arrays() | {"motor_start": np.array([start, -1, -1])}
    np.savez(tmp_path / "x.npz", **content, sample_rate_hz=RATE, piezo_unit="V")
    with pytest.raises(InputError, match=f"'motor_start' of pinch 0 .*{start}"):
        import_path(tmp_path / "x.npz", tmp_path / "out")
    assert not (tmp_path / "out").exists()
