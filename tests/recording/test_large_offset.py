"""Small vibrations on a large offset: imports keep them, or are refused."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat, wavfile

from firstcontact.core import InputError
from firstcontact.recording import import_path

Values = np.ndarray[Any, np.dtype[Any]]
Make = Callable[[Path, Values], dict[str, Any]]
CHANNELS = "variable,sensor,finger,rate_hz\nx,hydrophone,index,5000\ny,hydrophone,thumb,5000\n"


def npz(path: Path, values: Values) -> dict[str, Any]:
    np.savez(path / "x.npz", hydrophone=values, sample_rate_hz=5000, hydrophone_unit="Pa")
    return {"path": path / "x.npz"}


def mat(path: Path, values: Values) -> dict[str, Any]:
    savemat(path / "x.mat", {"x": values[0, :, :1], "y": values[0, :, 1:]})
    (path / "channels.csv").write_text(CHANNELS)
    return {"path": path / "x.mat", "channels": path / "channels.csv"}


def wav(path: Path, values: Values) -> dict[str, Any]:
    wavfile.write(path / "x.wav", 5000, values[0])
    (path / "x.txt").write_text("0.1\t0.1\tfoam\n")
    return {"path": path / "x.wav"}


def table(path: Path, values: Values) -> dict[str, Any]:
    rows = [["pinch", "hydrophone_index", "hydrophone_thumb", "hydrophone_unit"]]
    rows += [["0", repr(float(a)), repr(float(b)), "Pa"] for a, b in values[0]]
    with (path / "x.csv").open("w", newline="") as stream:
        csv.writer(stream).writerows(rows)
    return {"path": path / "x.csv", "rate": 5000.0}


MAKERS = [npz, mat, wav, table]


@pytest.mark.parametrize("make", MAKERS)
@pytest.mark.parametrize("offset", [0.0, 1.0, 1e2, 1e6])
@pytest.mark.parametrize("column", [0, 1])
def test_vibrations_keep_a_thousandth_of_their_rms_or_are_refused(
    tmp_path: Path, make: Make, offset: float, column: int
) -> None:
    values = np.random.default_rng(0).normal(0, 1e-3, (1, 1000, 2))
    values[..., column] += offset
    given = make(tmp_path, values)
    if offset > 30:
        with pytest.raises(InputError, match="offset"):
            import_path(out=tmp_path / "out", **given)
        assert not (tmp_path / "out").exists()
    else:
        (pinch,) = import_path(out=tmp_path / "out", **given)
        assert np.abs(pinch.vibration() - values[0]).max() < 1e-6


@pytest.mark.parametrize("make", MAKERS)
def test_a_constant_column_is_not_refused(tmp_path: Path, make: Make) -> None:
    values = np.random.default_rng(0).normal(0, 1e-3, (1, 1000, 2))
    values[..., 1] = 1.65
    (pinch,) = import_path(out=tmp_path / "out", **make(tmp_path, values))
    assert np.ptp(pinch.vibration()[:, 1]) == 0


def test_the_offsets_of_pinches_count_apart(tmp_path: Path) -> None:
    values = np.random.default_rng(0).normal(0, 1e-3, (2, 1000, 1))
    values += np.array([1000, -1000])[:, None, None]
    with pytest.raises(InputError, match="hydrophone"):
        import_path(**npz(tmp_path, values), out=tmp_path / "out")
