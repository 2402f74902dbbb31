"""A killed import leaves no file that could be mistaken for a recording."""

import signal
import subprocess
import sys

import numpy as np
import pytest

from firstcontact import import_recordings
from firstcontact.core import InputError
from firstcontact.recording import load_dataset
from firstcontact.recording.dataset import find_recordings
from firstcontact_lab.study.run import recorded

# Dies when all recordings are written and none has its place yet.
KILLED = """
import os, signal, sys
from pathlib import Path
from firstcontact.collect import importing as importing
write = importing.write_dataset
def die(*arguments):
    write(*arguments)
    os.kill(os.getpid(), signal.SIGKILL)
importing.write_dataset = die
importing.import_recordings(Path(sys.argv[1]), Path(sys.argv[2]))
"""


@pytest.fixture
def arrays(tmp_path):
    piezo = np.random.default_rng(1).normal(size=(3, 600, 1)).astype(np.float32)
    path = tmp_path / "x.npz"
    np.savez(path, piezo=piezo, shore_a=[1, 2, 3], sample_rate_hz=4936, piezo_unit="V")
    return path


@pytest.fixture
def killed_folder(tmp_path, arrays):
    """Folder in which an import into its subfolder ``o`` was killed."""
    folder = tmp_path / "data"
    folder.mkdir()
    command = [sys.executable, "-c", KILLED, str(arrays), str(folder / "o")]
    assert subprocess.run(command, check=False).returncode == -signal.SIGKILL
    assert list(folder.rglob("*.mcap"))
    return folder


def test_leftovers_of_a_killed_import_are_not_read(killed_folder, arrays, tmp_path):
    with pytest.raises(InputError, match=killed_folder.name):
        find_recordings(killed_folder)
    import_recordings(arrays, killed_folder / "other")
    assert len(load_dataset(killed_folder)) == 3
    assert len(recorded(killed_folder, tmp_path / "study")) == 3
    # The next import to the same place removes the leftovers.
    import_recordings(arrays, killed_folder / "o")
    assert sorted(p.name for p in killed_folder.iterdir()) == ["o", "other"]
    with pytest.raises(InputError, match=str(killed_folder / "o")):
        import_recordings(arrays, killed_folder / "o")
