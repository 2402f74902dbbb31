"""Output of ``inspect``, and round trips of export and import."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from firstcontact.cli.main import main
from firstcontact.core import (
    Block,
    Contact,
    Dataset,
    Finger,
    Label,
    Layout,
    Pinch,
    Role,
    fingertip_layout,
)
from firstcontact.recording import EXPORTERS, Header, Marker, RecordingWriter, write_dataset
from firstcontact.recording.dataset import pause_between
from processes import ON_FULL_DISK


def pinch(seed: int, layout: Layout, samples: int = 400) -> Pinch:
    """Return a pinch in which both fingers vibrate after contact, forces rise and strips close."""
    rng = np.random.default_rng(seed)
    contacts = (
        Contact(Finger(seed % 2), 120, 120),
        Contact(Finger(1 - seed % 2), 180 + seed, 180 + seed),
    )
    data = rng.normal(0, 30, (samples, 16))
    data[:, :2] += 16384
    for contact in contacts:
        offsets = np.arange(samples - contact.sample)
        data[contact.sample :, contact.finger] += 4000 * np.exp(-offsets / 60) * np.sin(offsets / 8)
        data[contact.sample :, 2 + 6 * contact.finger : 8 + 6 * contact.finger] += (
            offsets[:, None] * 20
        )
        data[contact.sample :, 14 + contact.finger] = 1
        data[: contact.sample, 14 + contact.finger] = 0
    label = Label(
        "Äpfel", 28.0, None, f"a{seed}", f"s{seed % 2}", Role(("train", "test")[seed % 2])
    )
    return Pinch(data.astype(np.int16), layout, label, 0, contacts)


@pytest.fixture
def dataset() -> Dataset:
    return Dataset(pause_between([pinch(i, fingertip_layout()) for i in range(4)]), "synthetic")


@pytest.fixture
def recordings(tmp_path: Path, dataset: Dataset) -> Path:
    folder = tmp_path / "recordings"
    folder.mkdir()
    write_dataset(dataset, folder, Header(dataset.layout, "synthetic", notes="by hand"))
    return folder


def test_an_export_never_overwrites_and_leaves_nothing_half(tmp_path, recordings, dataset, capsys):
    out = tmp_path / "x.h5"
    out.write_text("mine")
    arguments = ["export", str(recordings), "--to", "hdf5", "--out"]
    assert main([*arguments, str(out)]) == 2
    assert "choose another path" in capsys.readouterr().err
    assert out.read_text() == "mine"
    with RecordingWriter(recordings / "long.mcap", Header(dataset.layout, "synthetic")) as writer:
        writer.pinch(pinch(1, dataset.layout, samples=500))
    original = sorted(tmp_path.rglob("*"))
    assert main([*arguments, str(tmp_path / "y.h5")]) == 2
    assert "400 to 500 samples" in capsys.readouterr().err
    assert main([*arguments, str(out / "below.h5")]) == 2
    assert "cannot be written" in capsys.readouterr().err
    assert sorted(tmp_path.rglob("*")) == original


def test_inspect_says_what_is_in_a_recording(recordings, capsys):
    file = sorted(recordings.iterdir())[0]
    assert main(["inspect", str(file)]) == 0
    output = capsys.readouterr().out
    for words in (
        "source      synthetic",
        "session     s0",
        "by hand",
        "4936 Hz",
        "16 (int16)",
        "800 in 2 stretches of 2 epochs, 0.162 s",
        "pinches     2",
        "Äpfel, 28 Shore A, specimen a0, train; 81.0 ms, index first at 24.3 ms, offset 12.16 ms",
        "skipped     nothing",
    ):
        assert words in output


def test_inspect_counts_many_markers_and_lists_them_if_asked(tmp_path, dataset, capsys):
    path = tmp_path / "marked.mcap"
    with RecordingWriter(path, Header(layout=dataset.layout, source="synthetic")) as writer:
        writer.write(Block(np.zeros((500, dataset.layout.width), np.int16)))
        for sample in range(40):
            writer.marker(Marker(sample, f"object {sample}"))
    assert main(["inspect", str(path)]) == 0
    assert "object 3" not in capsys.readouterr().out
    assert main(["inspect", str(path), "--markers"]) == 0
    assert capsys.readouterr().out.count("object") == 40


def test_inspect_sums_up_a_folder(recordings, dataset, capsys):
    assert main(["inspect", str(recordings)]) == 0
    printed = capsys.readouterr().out
    assert f"pinches     {len(dataset)}," in printed
    assert all(name in printed for name in set(dataset.objects.tolist()))
    assert main(["inspect", str(recordings), "--plot", "pinch.png"]) == 2


def test_inspect_says_what_is_damaged(recordings, capsys):
    file = sorted(recordings.iterdir())[0]
    file.write_bytes(file.read_bytes()[:-2000])
    assert main(["inspect", str(file)]) == 0
    assert "skipped     the file was not closed" in capsys.readouterr().out


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_inspect_draws_a_pinch(tmp_path, recordings, suffix):
    file = sorted(recordings.iterdir())[1]
    picture = tmp_path / f"pinch{suffix}"
    assert main(["inspect", str(file), "--plot", str(picture), "--pinch", "1"]) == 0
    start = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}[suffix]
    assert picture.read_bytes().startswith(start)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--plot", "pinch.txt"), "must end in .png"),
        (("--plot", "pinch.png", "--pinch", "7"), "pinch 7"),
    ],
)
def test_inspect_refuses_what_it_cannot_draw(recordings, capsys, monkeypatch, more, words):
    monkeypatch.chdir(recordings)
    file = sorted(recordings.iterdir())[0]
    assert main(["inspect", str(file), *more]) == 2
    assert words in capsys.readouterr().err
    assert not list(recordings.glob("pinch*"))


FORMATS = list(EXPORTERS)
LAYOUT = fingertip_layout()


@pytest.fixture
def two_sessions(tmp_path: Path) -> Path:
    """Write two sessions of three pinches, one megabyte when exported."""
    rng = np.random.default_rng(1)
    pinches = [
        Pinch(rng.integers(-99, 99, (2000, 16)).astype(np.int16), LAYOUT, Label("a", 20.0, None, s))
        for s in "112211"
    ]
    folder = tmp_path / "two_sessions"
    folder.mkdir()
    write_dataset(Dataset(pause_between(pinches)), folder, Header(LAYOUT, "synthetic"))
    return folder


@pytest.mark.parametrize("to", FORMATS)
def test_on_a_full_disk_it_ends_with_one_sentence(tmp_path: Path, two_sessions: Path, to: str):
    out = tmp_path / "out" / "x"
    command = [sys.executable, "-c", ON_FULL_DISK, "100000"]
    command += ["export", str(two_sessions), "--to", to, "--out", str(out)]
    process = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (process.returncode, process.stderr.count("\n")) == (2, 1), process.stderr
    assert "cannot be written (" in process.stderr
    assert "File too large" in process.stderr
    assert list(out.parent.iterdir()) == []
