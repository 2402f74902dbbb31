"""An export never overwrites a file, and leaves no incomplete file."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from firstcontact.core import Dataset, Label, Pinch, fingertip_layout
from firstcontact.recording import EXPORTERS, Header, write_dataset
from firstcontact.recording.dataset import pause_between

FORMATS = list(EXPORTERS)
LAYOUT = fingertip_layout()

# The kernel refuses to write a file any longer than this, as a full disk does.
FULL = """
import resource, sys
from firstcontact.cli.main import main
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
sys.exit(main(sys.argv[1:]))
"""


@pytest.fixture
def recordings(tmp_path: Path) -> Path:
    """Write two sessions of three pinches, one megabyte when exported."""
    rng = np.random.default_rng(1)
    pinches = [
        Pinch(rng.integers(-99, 99, (2000, 16)).astype(np.int16), LAYOUT, Label("a", 20.0, None, s))
        for s in "112211"
    ]
    folder = tmp_path / "recordings"
    folder.mkdir()
    write_dataset(Dataset(pause_between(pinches)), folder, Header(LAYOUT, "synthetic"))
    return folder


@pytest.mark.parametrize("to", FORMATS)
def test_on_a_full_disk_it_ends_with_one_sentence(tmp_path: Path, recordings: Path, to: str):
    out = tmp_path / "out" / "x"
    command = [sys.executable, "-c", FULL]
    command += ["export", str(recordings), "--to", to, "--out", str(out)]
    process = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (process.returncode, process.stderr.count("\n")) == (2, 1), process.stderr
    assert "cannot be written (" in process.stderr
    assert "File too large" in process.stderr
    assert list(out.parent.iterdir()) == []
