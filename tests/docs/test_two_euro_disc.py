"""Every command of the page about the disc, on taps of the twin that PortAudio hears."""

from __future__ import annotations

import re
import runpy
import shlex
from pathlib import Path

import numpy as np
import pytest
from pages import ROOT, fences

from firstcontact.cli.main import main
from sound import heard_here

PAGE = ROOT / "docs/tutorial/two-euro-disc.md"
#: Hardness of what is tapped; at first nothing is.
SHORES = {"putty": 10.0, "eraser": 29.0, "heel": 60.0}


def commands() -> list[list[str]]:
    """The words of each command."""
    text = "".join(f.body for f in fences(PAGE) if f.mark == "disc")
    return [w for line in text.replace("\\\n", " ").splitlines() if (w := shlex.split(line))]


def test_every_command_runs_and_hard_things_sound_hard(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    tape = runpy.run_path(str(ROOT / "examples/tap_tape.py"))["tape"]
    rest = (40 * np.random.default_rng(0).standard_normal(48_000 * 20)).astype(np.int16)
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    assert len(commands()) == 9
    for name, *words in commands():
        assert name == "firstcontact"
        samples = rest
        if "--object" in words:  # more taps than are wanted: at the tape's end the input is gone
            samples = tape(SHORES[words[words.index("--object") + 1]], 13, 1)
        elif words[0] == "live":
            samples = tape(60.0, 7, 2)
        with heard_here(tmp_path, samples):
            ended = main(words)
        said = capsys.readouterr()
        assert ended == 0, f"{words}\n{said.out}\n{said.err}"
    values = [float(v) for v in re.findall(r"pinch \d+: sensor first, ([\d.]+) Shore A", said.out)]
    assert len(values) == 4
    assert 45 < np.median(values) < 75
