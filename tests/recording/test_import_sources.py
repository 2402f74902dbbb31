"""Origin of imported data: as the file or --source states it, otherwise unknown."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.io import wavfile

from firstcontact.cli.main import main
from firstcontact.core import InputError
from firstcontact.recording import import_path, load_dataset

DATA = np.random.default_rng(1).normal(size=(2, 60, 1)).astype(np.float32)


def npz(folder: Path, source: str) -> Path:
    fields = {"source": source} if source else {}
    np.savez(folder / "x.npz", piezo=DATA, sample_rate_hz=5000, piezo_unit="V", **fields)
    return folder / "x.npz"


def wav(folder: Path, source: str) -> Path:
    (folder / "w").mkdir(exist_ok=True)
    for k in range(2):
        wavfile.write(folder / "w" / f"{k}.wav", 5000, DATA[k])
    head, cell = (",source", f",{source}") if source else ("", "")
    (folder / "w" / "labels.csv").write_text(f"file{head}\n0.wav{cell}\n1.wav{cell}\n")
    return folder / "w"


def csv(folder: Path, source: str) -> Path:
    head, cell = (",source", f",{source}") if source else ("", "")
    rows = [f"{k // 60},{k / 5000},{v}{cell}\n" for k, v in enumerate(DATA.ravel())]
    (folder / "x.csv").write_text(f"pinch,time_s,piezo_index{head}\n" + "".join(rows))
    return folder / "x.csv"


MAKERS = [npz, wav, csv]
Maker = Callable[[Path, str], Path]


@pytest.mark.parametrize("make", MAKERS)
@pytest.mark.parametrize(
    ("file_source", "option_source", "source"),
    [
        ("", None, "unknown"),
        ("", "real", "real"),
        ("", "unknown", "unknown"),
        ("real", None, "real"),
        ("synthetic", "synthetic", "synthetic"),
        ("unknown", "real", "real"),
    ],
)
def test_source_comes_from_the_file_or_the_option(
    tmp_path: Path, make: Maker, file_source: str, option_source: str | None, source: str
) -> None:
    import_path(make(tmp_path, file_source), tmp_path / "o", source=option_source)
    dataset = load_dataset(tmp_path / "o")
    assert dataset.source == source
    assert any("is unknown" in n and "--source" in n for n in dataset.notes) == (
        source == "unknown"
    )


@pytest.mark.parametrize("make", MAKERS)
@pytest.mark.parametrize("option_source", ["twin", "unknown"])
def test_contradicting_sources_are_refused(tmp_path: Path, make: Maker, option_source: str) -> None:
    with pytest.raises(InputError, match=f"source .*real.*{option_source}"):
        import_path(make(tmp_path, "real"), tmp_path / "o", source=option_source)
    assert not (tmp_path / "o").exists()


@pytest.mark.parametrize("make", MAKERS)
def test_unknown_source_is_refused(tmp_path: Path, make: Maker) -> None:
    with pytest.raises(InputError, match=r"'source' .*'martian'"):
        import_path(make(tmp_path, "martian"), tmp_path / "o")


def test_command_sets_and_shows_the_source(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = wav(tmp_path, "")
    assert main(["import", str(path), "--source", "real", "--out", str(tmp_path / "o")]) == 0
    assert "source real" in capsys.readouterr().out
    assert main(["inspect", str(tmp_path / "o" / "000_1.mcap")]) == 0
    assert "source      real" in capsys.readouterr().out
