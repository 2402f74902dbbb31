"""Every command of the page about the disc, on taps of the twin that PortAudio hears."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pages import ROOT, fences

from sound import playing

PAGE = ROOT / "docs/tutorial/two-euro-disc.md"
#: Hardness of what is tapped; at first nothing is.
SHORES = {"putty": 10.0, "eraser": 29.0, "heel": 60.0}


def commands() -> list[str]:
    """Each command, with the lines that go on with it."""
    text = "".join(f.body for f in fences(PAGE) if f.mark == "disc")
    return [line for line in text.replace("\\\n", " ").splitlines() if line.strip()]


def made(shore: float, taps: int, seed: int) -> np.ndarray:
    """The tape of ``examples/tap_tape.py``."""
    code = (
        "import sys, pathlib; sys.path.insert(0, 'examples'); import tap_tape; "
        f"pathlib.Path(sys.argv[1]).write_bytes(tap_tape.tape({shore}, {taps}, {seed}).tobytes())"
    )
    out = Path(os.environ["TAPES"]) / f"{shore:g}-{taps}-{seed}"
    subprocess.run([sys.executable, "-c", code, str(out)], cwd=ROOT, check=True)
    return np.fromfile(out, np.int16)


def test_every_command_runs_and_hard_things_sound_hard(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TAPES", str(tmp_path))
    scripts = str(Path(sys.executable).parent)
    work = tmp_path / "work"
    work.mkdir()
    rest = (40 * np.random.default_rng(0).standard_normal(48_000 * 20)).astype(np.int16)
    told = ""
    for command in commands():
        thing = re.search(r"--object (\w+)", command)
        if thing:  # more than are wanted: the input is gone at the end of the tape
            samples = made(SHORES[thing[1]], 13, 1)
        else:
            samples = made(60.0, 7, 2) if " live " in command else rest
        environment = {**os.environ, **playing(tmp_path, samples)}
        environment["PATH"] = scripts + os.pathsep + environment["PATH"]
        done = subprocess.run(
            ["bash", "-c", command], cwd=work, env=environment, capture_output=True, text=True
        )
        assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
        told = done.stdout
    values = [float(v) for v in re.findall(r"pinch \d+: sensor first, ([\d.]+) Shore A", told)]
    assert len(values) == 4
    assert 45 < np.median(values) < 75
