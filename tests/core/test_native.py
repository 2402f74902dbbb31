"""The compiled functions are required, and check their arguments."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from compiled_kernels import built_kernels, compiled_kernels
from firstcontact.core import _native

BLOCKED = """
import sys
sys.modules["firstcontact.core._compiled"] = None
from firstcontact.cli.main import main
sys.exit(main(["simulate", "--out", "out"]))
"""


def test_without_them_one_sentence_names_the_packages_to_install(tmp_path: Path) -> None:
    command = [sys.executable, "-c", BLOCKED]
    process = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert process.returncode == 2
    assert process.stderr.count("\n") == 1
    assert all(name in process.stderr for name in ("gcc", "libc6-dev", "python3-dev"))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("age", "in_checkout", "is_used"),
    [(-60.0, True, False), (60.0, True, True), (-60.0, False, True)],
)
def test_only_a_checkout_refuses_a_module_older_than_its_sources(
    age: float, in_checkout: bool, is_used: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not in_checkout:
        monkeypatch.setattr(_native, "_CLONE", tmp_path)
    module = ModuleType("_compiled")
    module.__file__ = str(tmp_path / "_compiled.so")
    Path(module.__file__).touch()
    newest = max(p.stat().st_mtime for p in Path(_native.__file__).with_name("c").iterdir())
    os.utime(module.__file__, (newest + age, newest + age))
    monkeypatch.setitem(sys.modules, "firstcontact.core._compiled", module)
    assert (_native._load() is module) == is_used


def detector(window: int = 110, line: int = 17) -> object:
    lengths = np.array([2, 4, 7, 11, 15, 30], np.int32)
    return built_kernels().detector(window, 2, 4, 44, 3.0, 0.1, lengths, np.zeros(line))


@pytest.mark.parametrize(("window", "line"), [(40, 17), (5000, 17), (110, 16), (1, 17)])
def test_a_detector_that_does_not_fit_is_refused(window: int, line: int) -> None:
    with pytest.raises(ValueError, match=r"."):
        detector(window, line)


@pytest.mark.parametrize(
    ("end", "count", "samples"), [(109, 1, 200), (110, 47, 200), (201, 1, 200), (110, 0, 200)]
)
def test_windows_outside_the_samples_are_refused(end: int, count: int, samples: int) -> None:
    onsets = np.empty((count, 2), np.int32)
    ones, weights, memory = np.ones(2), np.zeros((2, 13)), np.full((2, 8, 2), np.nan)
    past, judged = np.zeros((samples, 2)), np.ones(2, np.bool_)
    arguments = (ones, ones, weights, judged, memory, onsets)
    with pytest.raises(ValueError, match=r"."):
        built_kernels().judge(detector(), past, 0, end, count, *arguments)


def test_arrays_of_another_size_are_refused() -> None:
    onsets, past, ones = np.empty((1, 2), np.int32), np.zeros((200, 2)), np.ones(2)
    weights, memory = np.zeros((2, 13)), np.full((2, 8, 2), np.nan)
    good = [ones, ones, weights, np.ones(2, np.bool_), memory, onsets]
    built_kernels().judge(detector(), past, 0, 110, 1, *good)
    for place in range(len(good)):
        wrong = [array.ravel()[:-1] if k == place else array for k, array in enumerate(good)]
        with pytest.raises(ValueError, match=r"."):
            built_kernels().judge(detector(), past, 0, 110, 1, *(wrong + good)[:6])


def test_a_kernel_takes_its_own_constants_only() -> None:
    with pytest.raises(ValueError, match=r"."):
        built_kernels().predict(detector(), detector(), np.zeros(74), 10, 0, np.zeros(5), 0.0)


def test_the_sources_compile_without_warnings() -> None:
    assert compiled_kernels().detector is not None
