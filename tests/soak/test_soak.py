"""Test of a short soak of all live sources."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from random import Random

import numpy as np
import pytest
from soak_links import LINKS, RATE, LslLink

from firstcontact.core import Block, Channel, ChannelKind, Layout
from firstcontact.device import Health
from firstcontact.recording import Header, RecordingWriter, read_recording
from soak import check_counts

LAYOUT = Layout((Channel("count", ChannelKind.VIBRATION, None, "V"),), RATE)


def findings(
    tmp_path: Path, parts: list[tuple[int, int, int, int]], received: int, lost: int
) -> list[str]:
    """Return the findings of a soak whose recording has these parts.

    A part has its epoch, its first sample's number, the number that this sample holds, and its
    length.
    """
    link = LslLink(tmp_path, Random(0))
    link.last = {0: 999, 1: 499}
    path = tmp_path / "a.mcap"
    with RecordingWriter(path, Header(LAYOUT, "synthetic", dtype="float32")) as writer:
        for epoch, first, says, count in parts:
            data = np.arange(says, says + count, dtype=np.float32)[:, None]
            writer.write(Block(data, first, epoch))
    health = replace(Health(), samples=received, lost_samples=lost)
    return check_counts(link, health, read_recording(path))[1]


def test_counts_that_add_up_are_no_finding(tmp_path: Path) -> None:
    parts = [(0, 0, 0, 300), (0, 400, 400, 600), (1, 0, 20, 480)]
    assert findings(tmp_path, parts, 1380, 100) == []


@pytest.mark.parametrize(
    ("parts", "received", "lost"),
    [
        ([(0, 0, 0, 300), (0, 400, 400, 600)], 900, 99),  # a loss is not counted
        ([(0, 0, 0, 300), (0, 400, 401, 599)], 899, 100),  # a gap is too short
        ([(0, 0, 0, 300), (0, 400, 400, 500)], 900, 100),  # a recording ends too early
        ([(0, 0, 0, 300), (0, 400, 400, 500)], 800, 100),  # the last samples are missing
    ],
)
def test_counts_that_do_not_add_up_are_findings(
    parts: list[tuple[int, int, int, int]], received: int, lost: int, tmp_path: Path
) -> None:
    assert findings(tmp_path, parts, received, lost)


def test_link_that_cannot_run_here_is_a_finding_with_the_remedy(tmp_path: Path) -> None:
    (tmp_path / "sounddevice.py").write_text("raise OSError('no library')")
    program = Path(__file__).with_name("soak.py")
    paths = os.pathsep.join(filter(None, [str(tmp_path), os.environ.get("PYTHONPATH")]))
    soak = subprocess.run(
        [sys.executable, program, "--links", "sound", "--out", str(tmp_path / "soak.json")],
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
    )
    assert (soak.returncode, soak.stderr) == (1, "")
    assert "libportaudio2" in soak.stdout


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_two_minutes_of_all_sources_with_faults_end_with_exact_counts(tmp_path: Path) -> None:
    pytest.importorskip("pylsl")
    words = ["--minutes", "2", "--out", str(tmp_path / "soak.json")]
    program = Path(__file__).with_name("soak.py")
    subprocess.run([sys.executable, program, *words], check=False, timeout=540)
    links = json.loads((tmp_path / "soak.json").read_text())["links"]
    assert {name: link["wrong"] for name, link in links.items()} == {name: [] for name in LINKS}
    assert all(link["faults"] and link["received"] > 60 * RATE for link in links.values())
