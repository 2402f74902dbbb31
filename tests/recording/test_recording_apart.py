"""Calls in a separate process: results are returned, loops and crashes become errors."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from firstcontact.core import InputError, _children
from firstcontact.recording._apart import apart

# Imports a file while a thread runs, at its top level, as short scripts do.
SCRIPT = """
import sys, threading
import firstcontact as fc
print("started")
threading.Thread(target=threading.Event().wait, daemon=True).start()
print(len(fc.import_recordings(sys.argv[1], sys.argv[2])))
"""


@pytest.fixture(params=["alone", "with a thread"])
def _threads(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(_children, "subprocess", subprocess)  # a new process, as for users
    end = threading.Event()
    thread = threading.Thread(target=end.wait)
    if request.param != "alone":
        thread.start()
    yield
    end.set()
    if thread.ident is not None:
        thread.join()


def double(x: np.ndarray) -> np.ndarray:
    return 2 * x


def loop() -> None:
    while True:
        pass


def refuse() -> None:
    raise InputError("x.h5: object is a link: copy it")


def crash() -> None:
    os.abort()


@pytest.mark.usefixtures("_threads")
def test_result_is_returned() -> None:
    assert apart(60.0, double, np.arange(3)).tolist() == [0, 2, 4]


@pytest.mark.usefixtures("_threads")
def test_input_error_is_passed_on() -> None:
    with pytest.raises(InputError, match="object is a link: copy it"):
        apart(60.0, refuse)


@pytest.mark.usefixtures("_threads")
def test_endless_function_is_ended() -> None:
    with pytest.raises(OSError, match="reading it does not end"):
        apart(0.2, loop)


@pytest.mark.usefixtures("_threads")
def test_crash_is_an_input_error() -> None:
    with pytest.raises(OSError, match="reading it crashes"):
        apart(60.0, crash)


def test_script_with_threads_runs_once(tmp_path: Path) -> None:
    from scipy.io import savemat

    arrays = {"piezo": np.zeros((3, 1000)), "sample_rate_hz": 5000.0, "piezo_unit": "V"}
    savemat(tmp_path / "x.mat", arrays)
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    command = [sys.executable, str(script), str(tmp_path / "x.mat"), str(tmp_path / "out")]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert output.split() == ["started", "3"]
