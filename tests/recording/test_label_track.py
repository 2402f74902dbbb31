"""Audacity label tracks, and FLAC files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.io import wavfile

from firstcontact.cli.main import main
from firstcontact.core import Dataset
from firstcontact.recording import load_dataset

RATE = 48_000


@pytest.fixture
def wav(tmp_path: Path) -> Path:
    path = tmp_path / "long.wav"
    wavfile.write(path, RATE, np.arange(RATE, dtype=np.int32).astype(np.int16))
    return path


def flac(tmp_path: Path, subtype: str = "PCM_16", samples: int = RATE) -> Path:
    soundfile = pytest.importorskip("soundfile")
    path = tmp_path / f"{subtype}.flac"
    soundfile.write(path, np.arange(samples, dtype=np.int32).astype(np.int16), RATE, subtype)
    return path


def track(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "labels.txt"
    path.write_bytes(text.encode())
    return path


def import_track(tmp_path: Path, path: Path, events: Path) -> Dataset:
    out = tmp_path / f"out-{path.name}"
    assert main(["import", str(path), "--events", str(events), "--out", str(out)]) == 0
    return load_dataset(out)


def check_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, path: Path, events: Path, *words: str
) -> None:
    out = tmp_path / "out"
    assert main(["import", str(path), "--events", str(events), "--out", str(out)]) == 2
    message = capsys.readouterr().err
    assert message.count("\n") == 1
    for word in words:
        assert word in message, message
    assert not out.exists()


LABELS = (
    "0.250000\t0.250000\teraser; shore_a=40; session=monday\n\\\t100\t200\n"
    "0,5\t0,75\tshore_a=20; object=foam; session=monday\r\n"
)


def test_points_and_ranges_become_labelled_contacts(wav: Path, tmp_path: Path) -> None:
    dataset = import_track(tmp_path, wav, track(tmp_path, LABELS))
    assert dataset.objects.tolist() == ["eraser", "foam"]
    assert dataset.shore_a.tolist() == [40, 20]
    for pinch, at in zip(dataset.pinches, (12_000, 24_000), strict=True):
        assert pinch.first is not None
        assert pinch.data[pinch.first.sample - pinch.first_sample, 0] == at


@pytest.mark.parametrize("subtype", ["PCM_16", "PCM_24"])
def test_flac_imports_like_its_wav(wav: Path, tmp_path: Path, subtype: str) -> None:
    events = track(tmp_path, LABELS)
    from_wav = import_track(tmp_path, wav, events)
    from_flac = import_track(tmp_path, flac(tmp_path, subtype), events)
    for a, b in zip(from_wav.pinches, from_flac.pinches, strict=True):
        assert np.array_equal(a.vibration(), b.vibration())
        assert a.truth == b.truth


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ("no labels",)),
        ("one two three\n", ("line 1", "no label")),
        ("0.5\t0.25\tback\n", ("line 1",)),
        ("nan\tnan\tx\n", ("line 1",)),
        ("2.5\t2.5\tx\n", ("line 1", "outside")),
        ("0.1\t0.1\tsize=3\n", ("line 1", "size=3")),
        ("0.1\t0.1\tshore_a=3\n0.2\t0.2\tfoam\n", ("line 2", "shore_a")),
        ("0.1\t0.1\tshore_a=300\n", ("'shore_a' of line 1",)),
        ("0.1\t0.1\n0.1\t0.1\n", ("same contact",)),
        ("\udcff", ("UTF-8",)),
    ],
)
def test_invalid_label_track_is_refused(
    wav: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, words: tuple[str, ...]
) -> None:
    path = tmp_path / "labels.txt"
    path.write_bytes(text.encode(errors="surrogateescape"))
    check_refused(capsys, tmp_path, wav, path, *words)


def test_a_damaged_flac_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    content = flac(tmp_path).read_bytes()
    events = track(tmp_path, LABELS)
    for name, raw in (("cut", content[:-4000]), ("none", b""), ("noise", bytes(range(256)) * 20)):
        path = tmp_path / f"{name}.flac"
        path.write_bytes(raw)
        check_refused(capsys, tmp_path, path, events, path.name)
