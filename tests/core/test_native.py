"""The compiled functions are required, and check their arguments."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

from compiled_kernels import compiled_kernels
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


def test_the_sources_compile_without_warnings() -> None:
    assert compiled_kernels().decode_samples is not None
