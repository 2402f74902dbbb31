"""MATLAB files: arrays of pinches, and signals at several rates described by a table."""

import os
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from firstcontact import import_recordings
from firstcontact.cli.main import main
from firstcontact.core import Finger, InputError, VibrationSensor
from firstcontact.recording import load_dataset

CHANNELS = """variable,sensor,finger,rate_hz,unit,scale,offset,column
pac,hydrophone,index,2200,,0.5,2000,all
pac2,hydrophone,thumb,2200,,0.5,2000,all
pressure,,index,100,,1,0,
skin,,thumb,100,,1,0,
"""


def variables(n=200, seed=0):
    """Return BioTac variables: packets of 22 samples in columns, and slower signals."""
    rng = np.random.default_rng(seed)
    count = np.arange(22 * n, dtype=np.uint16)
    return {
        "pac": count.reshape(n, 22).T,
        "pac2": 1 + count.reshape(n, 22).T,
        "pressure": rng.integers(0, 4000, (1, n)).astype(np.uint16),
        "skin": np.arange(3 * n, dtype=np.uint16).reshape(3, n),
        "joint": rng.normal(size=(1, n)),
    }


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "in"
    place.mkdir()
    for k, name in enumerate(("steel", "foam")):
        savemat(place / f"{name}.mat", variables(seed=k), do_compression=bool(k))
    (place / "labels.csv").write_text("file,object,session\nsteel.mat,steel,1\nfoam.mat,foam,2\n")
    (tmp_path / "channels.csv").write_text(CHANNELS)
    return place


def run(folder, out, *options):
    channels = str(out.parent / "channels.csv")
    return main(["import", str(folder), "--channels", channels, "--out", str(out), *options])


def test_each_mat_file_is_one_pinch_with_slower_signals(folder, tmp_path):
    assert run(folder, tmp_path / "out") == 0
    dataset = load_dataset(tmp_path / "out")
    assert sorted(dataset.objects.tolist()) == ["foam", "steel"]
    layout = dataset.layout
    assert layout.rate == 2200
    assert layout.vibration_fingers == (Finger.INDEX, Finger.THUMB)
    assert {c.sensor for c in layout.vibration} == {VibrationSensor.HYDROPHONE}
    for pinch in dataset.pinches:
        # x(:) in MATLAB's order is the order of time.
        assert np.array_equal(pinch.data[:, 0], np.arange(4400))
        assert np.array_equal(pinch.vibration()[:, 0], 0.5 * (np.arange(4400) - 2000))
        times, values = pinch.group("100_hz")
        assert times == pytest.approx(np.arange(200) / 100)
        assert np.array_equal(values[:, 2], 200 + np.arange(200))
    assert any("joint" in note for note in dataset.notes)


@pytest.mark.parametrize("shape", [(1, 1, 4400), (4400, 1), (4400, 1, 1), (4400, 2), (2, 1, 4400)])
def test_a_signal_lies_along_the_longest_side(folder, tmp_path, shape):
    count = np.arange(4400)
    signal = np.stack([count, -count]) if 2 in shape else count
    signal = signal.T if shape[0] == 4400 else signal
    savemat(tmp_path / "a.mat", {**variables(), "pac": signal.reshape(shape)})
    column = "0" if 2 in shape else ""
    (tmp_path / "channels.csv").write_text(CHANNELS.replace("all", column, 1))
    assert run(tmp_path / "a.mat", tmp_path / "out") == 0
    (pinch,) = load_dataset(tmp_path / "out")
    assert np.array_equal(pinch.data[:, 0], count)


def write_version_73(path, content):
    """Write a file as MATLAB does: reversed dimensions, and character codes."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in content.items():
            if isinstance(values, str):
                values = np.frombuffer(values.encode("utf-16-le"), "<u2")[None]
            file[name] = np.asarray(values).T
    with path.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file, made by a test".ljust(124) + b"\x00\x02IM")
    return path


def test_version_73_file_imports_equally(folder, tmp_path):
    assert run(folder / "steel.mat", tmp_path / "old") == 0
    new = write_version_73(tmp_path / "new.mat", variables())
    assert run(new, tmp_path / "new") == 0
    (old_pinch,), (new_pinch,) = (load_dataset(tmp_path / name).pinches for name in ("old", "new"))
    assert np.array_equal(old_pinch.data, new_pinch.data)
    assert np.array_equal(old_pinch.group("100_hz")[1], new_pinch.group("100_hz")[1])


def ours(**changes):
    piezo = np.random.default_rng(0).normal(size=(3, 300))
    return {"piezo": piezo, "sample_rate_hz": np.array([[5000.0]]), "piezo_unit": "V", **changes}


@pytest.mark.parametrize("columns", [1, 2])
def test_signals_in_columns_are_not_pinches_of_a_sample(tmp_path, columns):
    signals = np.random.default_rng(0).normal(size=(5000, columns))
    path = tmp_path / "column.mat"
    savemat(path, ours(piezo=signals))
    with pytest.raises(InputError, match=r"'piezo'.* transpose"):
        import_recordings(path, tmp_path / "out")
    assert not (tmp_path / "out").exists()
    savemat(path, ours(piezo=signals.T))
    dataset = import_recordings(path, tmp_path / "out")
    assert np.allclose([p.vibration()[:, 0] for p in dataset], signals.T)


CELLS = {
    "object": ["Äpfel \U0001f34e", "", "b" * 200],
    "specimen": [1.0, np.uint16(2), "three"],
    "session": ["mon", "mon", "tue"],
}


def test_arrays_and_cells_with_our_names_need_no_table(tmp_path):
    cells = {name: np.array(values, dtype=object) for name, values in CELLS.items()}
    labels = {"shore_a": [20, 40, 20], "first_contact": [100, -1, 120], "source": "synthetic"}
    savemat(tmp_path / "cells.mat", ours(**cells, **labels))
    dataset = import_recordings(tmp_path / "cells.mat", tmp_path / "out")
    assert dataset.source == "synthetic"
    assert dataset.shore_a.tolist() == [20, 40, 20]
    assert [p.first is None for p in dataset] == [False, True, False]
    assert sorted(dataset.objects.tolist()) == sorted(CELLS["object"])
    assert dataset.specimens.tolist() == ["1", "2", "three"]
    assert dataset.sessions.tolist() == CELLS["session"]


def test_cell_arrays_of_version_73_are_refused(tmp_path, check_refused):
    path = write_version_73(tmp_path / "cells.mat", ours())
    with h5py.File(path, "r+") as file:
        file["session"] = np.array([file.ref] * 3, h5py.ref_dtype)
    check_refused(path, "cells.mat", "'session'", "-v7")


def changed_variables(**changes):
    return {k: v for k, v in {**variables(), **changes}.items() if v is not None}


@pytest.mark.parametrize(
    ("content", "table", "words"),
    [
        (changed_variables(pac=None), CHANNELS, ("no variable 'pac'", "joint")),
        (changed_variables(pac=np.full((22, 200), np.nan)), CHANNELS, ("pac is NaN",)),
        (changed_variables(pac=np.zeros((22, 20))), CHANNELS, ("lasts", "rate_hz")),
        (changed_variables(pac=np.zeros((2, 3, 4))), CHANNELS, ("shape (2, 3, 4)",)),
        (changed_variables(pac=np.zeros((2, 1, 4400))), CHANNELS.replace("all", "2", 1), ("pac",)),
        (variables(), CHANNELS.replace("all", "", 1), ("pac has 22 columns", "'column'")),
        (variables(), CHANNELS.replace("all", "al", 1), ("'column' of line 2", "'al'")),
        (changed_variables(pac={"a": 1}), CHANNELS, ("neither numbers nor texts",)),
        (variables(), CHANNELS.replace("2200", "22"), ("rate_hz", "22")),
        (variables(), CHANNELS.replace(",2200,", ",,", 1), ("no 'rate_hz' of pac",)),
        (variables(), CHANNELS.replace("pac", "p" * 5000), ("line 2", "longer than 200")),
        (variables(), CHANNELS.replace("hydrophone", "nose"), ("line 2", "'nose'")),
        (variables(), CHANNELS.replace("hydrophone", ""), ("no kind of sensor",)),
        (variables(), CHANNELS.replace("thumb,2200", "index,2200"), ("two vibration channels",)),
        (variables(), CHANNELS.replace("variable", "name"), ("'variable' is missing",)),
        (variables(), CHANNELS.replace("0.5", "0"), ("'scale' of line 2",)),
        (variables(), "variable,sensor,column\npac,piezo,-1\n", ("'column' of line 2", "'-1'")),
    ],
)
def test_bad_signals_and_tables_are_refused(folder, tmp_path, check_refused, content, table, words):
    savemat(folder / "steel.mat", content)
    (tmp_path / "channels.csv").write_text(table)
    check_refused(folder, *words, channels=tmp_path / "channels.csv")


@pytest.mark.parametrize("keep", [0, 60, 127, 1000, 19_000])
def test_truncated_mat_file_is_refused(folder, tmp_path, check_refused, keep):
    path = folder / "steel.mat"
    path.write_bytes(path.read_bytes()[:keep])
    check_refused(folder, "steel.mat", channels=tmp_path / "channels.csv")


def test_codes_of_no_characters_are_refused(tmp_path, check_refused):
    path = tmp_path / "a.mat"
    savemat(path, ours(piezo_unit=np.array([0x110000, -1])))
    check_refused(path, "piezo_unit")


def test_missing_tables_and_rows_are_refused(folder, tmp_path, check_refused):
    check_refused(folder / "steel.mat", "--channels")
    (folder / "labels.csv").write_text("file,object\nsteel.mat,steel\n")
    check_refused(folder, "1 .mat file", channels=tmp_path / "channels.csv")


def test_real_biotac_recordings_run_through_a_study(biotac, tmp_path):
    maker = Path(__file__).parents[2] / "examples" / "biotac_tables.py"
    tables = [str(tmp_path / name) for name in ("labels.csv", "channels.csv")]
    subprocess.run([sys.executable, maker, str(biotac), *tables], check=True, env=os.environ)
    out = str(tmp_path / "out")
    options = ["--labels", tables[0], "--channels", tables[1], "--source", "real", "--out", out]
    assert main(["import", str(biotac), *options]) == 0
    dataset = load_dataset(tmp_path / "out")
    assert len(dataset) == 60
    assert len(set(dataset.objects.tolist())) == 6
    assert dataset.layout.rate == 2200
    times, values = dataset.pinches[0].group("100_hz")
    assert len(times) == len(dataset.pinches[0].data) // 22
    assert values.shape[1] >= 42
