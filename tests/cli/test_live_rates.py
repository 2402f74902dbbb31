"""``firstcontact live`` with samples at another rate than the models'."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from firstcontact.core import Dataset, Label
from firstcontact.models import load_model
from firstcontact.models.model_file import pretrained
from firstcontact.recording import Header, read_recording, write_dataset
from firstcontact.signal import resample_dataset
from firstcontact.twin import BLOCKS, CONDITIONS, draw_pinch, simulate_pinch
from firstcontact.twin.draw import draw_specimen
from trainings import recordings, resampled, run

PAPER_RIG = CONDITIONS["paper-rig"]

FAST = 8000.0


@pytest.fixture(scope="module")
def pinches() -> Dataset:
    simulated = []
    for n in range(4):
        kind = BLOCKS[n]
        draw = draw_pinch(3, PAPER_RIG, "s", draw_specimen(3, PAPER_RIG, kind, 0), n)
        label = Label(kind.name, kind.shore_a, session="s", specimen=kind.name)
        simulated.append(simulate_pinch(draw, label, 10_000 * n))
    return Dataset(tuple(simulated), "synthetic")


def recorded(pinches: Dataset, folder: Path) -> Path:
    folder.mkdir()
    layout = pinches.layout
    header = Header(layout, "synthetic", str(pinches.pinches[0].data.dtype))
    (path,) = write_dataset(pinches, folder, header)
    return path


@pytest.fixture(scope="module")
def fast_model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a detector and a window model for 8 kHz."""
    folder = tmp_path_factory.mktemp("fast")
    data = resampled(recordings(folder / "data"), FAST, folder / "at 8 kHz")
    assert run("train", data, "--rate", "8000", "--out", folder / "model") == 0
    return folder / "model"


class LiveOutput:
    """Output of ``live --json`` for a recording."""

    def __init__(self, capsys: pytest.CaptureFixture[str], path: Path, *arguments: Any) -> None:
        capsys.readouterr()
        self.code = run("live", "--device", path, "--speed", "inf", "--json", *arguments)
        out, self.messages = capsys.readouterr()
        self.events = [json.loads(line) for line in out.splitlines()]

    def select(self, kind: str) -> list[dict[str, Any]]:
        return [e for e in self.events if e["type"] == kind]

    @property
    def contacts(self) -> list[tuple[int, int, int]]:
        first = [e for e in self.select("contact") if e["first"]]
        return [(e["epoch"], e["contact"]["finger"], e["contact"]["sample"]) for e in first]


def test_a_device_at_another_rate_is_resampled_for_the_model(
    pinches: Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    direct = LiveOutput(capsys, recorded(pinches, tmp_path / "own"))
    folder = tmp_path / "recordings"
    path = recorded(resample_dataset(pinches, FAST), tmp_path / "fast")
    session = LiveOutput(capsys, path, "--record", "--recordings", folder)
    assert (direct.code, session.code) == (0, 0)
    assert "resampled" not in direct.messages
    (line,) = [line for line in session.messages.splitlines() if "resampled" in line]
    assert "8000" in line
    assert "4936" in line
    (header,) = session.select("descriptor")
    assert header["rate"] == 4936.0
    assert [c[:2] for c in session.contacts] == [c[:2] for c in direct.contacts]
    offsets = [t[2] - o[2] for t, o in zip(session.contacts, direct.contacts, strict=True)]
    assert np.abs(offsets).max() <= 0.003 * 4936
    assert len(session.select("estimate")) > 0.8 * len(direct.select("estimate")) > 0
    recording = read_recording(next(folder.glob("*.mcap")))
    assert (recording.header.layout.rate, recording.header.dtype) == (4936.0, "float32")
    count = sum(len(p.data) for p in pinches.pinches)
    assert recording.samples == pytest.approx(count, rel=0.01)


def test_a_network_of_another_rate_beside_them_is_named_and_left_out(
    pinches: Dataset, fast_model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = recorded(resample_dataset(pinches, FAST), tmp_path / "fast")
    alone = LiveOutput(capsys, path, "--model", fast_model)
    model = load_model(fast_model)
    network = pretrained()
    folder = replace(model, predictors=(network, *model.predictors)).save(tmp_path / "both")
    both = LiveOutput(capsys, path, "--model", folder)
    assert (alone.code, both.code) == (0, 0), both.messages
    assert alone.contacts == both.contacts != []
    assert "estimates come from svm" in alone.messages
    assert "network" not in alone.messages
    assert "network needs 4936 Hz" in both.messages
    assert {e["model"] for e in both.select("estimate")} == {"svm"}


def test_a_detector_of_another_rate_than_the_only_model_is_refused(
    pinches: Dataset, fast_model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = recorded(pinches, tmp_path / "own")
    session = LiveOutput(capsys, path, "--detector", fast_model)
    assert session.code == 2
    assert "8000" in session.messages
    assert session.events == []
