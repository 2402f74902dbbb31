"""Tests of functions that Numba compiles: announced, cached, and usable without a cache."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("numba")

from firstcontact.twin import _numba

FILTER = """
import sys
sys.modules["firstcontact.core._compiled"] = None
import numpy as np
from firstcontact.twin._filter import smoothed
assert len(smoothed(np.zeros(8, dtype=np.uint16))) == 8
"""


def test_compilation_is_logged_once_and_cached(tmp_path: Path) -> None:
    announced = []
    for _ in range(2):
        result = subprocess.run(
            [sys.executable, "-W", "error", "-c", FILTER],
            env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)},
            capture_output=True,
            text=True,
            check=True,
        )
        announced.append(result.stderr.splitlines())
    first_log, second_log = announced
    assert len(first_log) == 1
    assert "compiling" in first_log[0]
    assert second_log == []


def test_function_without_a_cache_folder_is_compiled(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(_numba._notice, "_given", False)
    monkeypatch.setattr(_numba._notice, "cached", True)
    source: dict[str, object] = {"__name__": "firstcontact.nowhere"}
    exec("def double(x):\n    return 2 * x", source)  # Numba has no file to keep it beside
    double = _numba.jit(source["double"], [])
    np.testing.assert_array_equal(double(np.arange(3.0)), [0.0, 2.0, 4.0])
    assert "NUMBA_CACHE_DIR" in caplog.text
