"""Measured closing speeds in recordings, imports and exports."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from firstcontact.core import ClosingSpeed, Dataset, InputError
from firstcontact.recording import (
    EXPORTERS,
    Header,
    export,
    import_path,
    load_dataset,
    write_dataset,
)
from firstcontact.signal import resample_dataset

SPEEDS = [ClosingSpeed(0.12, 0.003), None, ClosingSpeed(0.2, 0.0)]


def imported(folder: Path, **more: object) -> Dataset:
    piezo = np.random.default_rng(1).normal(size=(3, 80, 1)).astype(np.float32)
    columns = {"closing_speed": [0.12, -1, 0.2], "closing_speed_error": [0.003, -1, 0]} | more
    np.savez(folder / "x.npz", piezo=piezo, sample_rate_hz=5000, piezo_unit="V", **columns)
    return import_path(folder / "x.npz", folder / "out")


def speeds(dataset: Dataset) -> list[ClosingSpeed | None]:
    return [pinch.closing_speed for pinch in dataset.pinches]


def test_speeds_are_columns_of_an_import(tmp_path: Path) -> None:
    assert speeds(imported(tmp_path)) == SPEEDS
    assert speeds(load_dataset(tmp_path / "out")) == SPEEDS


@pytest.mark.parametrize(("to", "name"), [("hdf5", "y.h5"), ("csv", "y.csv")])
def test_speeds_round_trip_through_exports(tmp_path: Path, to: str, name: str) -> None:
    export(imported(tmp_path), EXPORTERS[to], tmp_path / name)
    assert speeds(import_path(tmp_path / name, tmp_path / "back")) == SPEEDS


def test_speeds_are_kept_by_resampling_and_by_recordings(tmp_path: Path) -> None:
    dataset = resample_dataset(imported(tmp_path), 10_000)
    assert speeds(dataset) == SPEEDS
    pinches = tuple(replace(p, data=p.data.astype(np.float32)) for p in dataset.pinches)
    header = Header(dataset.layout, dtype="float32")
    (path,) = write_dataset(replace(dataset, pinches=pinches), tmp_path, header)
    assert speeds(load_dataset(path)) == SPEEDS


@pytest.mark.parametrize("column", ["closing_speed", "closing_speed_error"])
@pytest.mark.parametrize("value", [-0.1, 11.0, np.nan])
def test_speeds_out_of_range_are_refused(tmp_path: Path, column: str, value: float) -> None:
    with pytest.raises(InputError, match=column):
        imported(tmp_path, **{column: [value, -1, 0]})


def test_a_speed_of_zero_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="closing_speed"):
        imported(tmp_path, closing_speed=[0.0, -1, 0.2])


@pytest.mark.parametrize("errors", [[0.003, -1, -1], None])
def test_a_speed_without_an_error_is_refused(tmp_path: Path, errors: list[float] | None) -> None:
    piezo = np.random.default_rng(1).normal(size=(3, 80, 1)).astype(np.float32)
    columns = {"closing_speed": [0.12, -1, 0.2]}
    if errors is not None:
        columns["closing_speed_error"] = errors
    path = tmp_path / "x.npz"
    np.savez(path, piezo=piezo, sample_rate_hz=5000, piezo_unit="V", **columns)
    with pytest.raises(InputError, match="closing_speed_error"):
        import_path(path, tmp_path / "out")
