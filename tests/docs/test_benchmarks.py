"""Tests of the program that runs all benchmarks."""

import ast
import json
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Names of the program ``benchmarks/run.py``."""
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return runpy.run_path(str(BENCHMARKS / "run.py"))


def test_every_benchmark_returns_ratios(run: dict[str, Any]) -> None:
    programs = run["programs"]()
    assert {p.stem for p in programs} >= {"decoding", "live", "scale", "twin"}
    for program in programs:
        functions = [
            f for f in ast.parse(program.read_text()).body if isinstance(f, ast.FunctionDef)
        ]
        (main,) = [f for f in functions if f.name == "main"]
        assert main.returns is not None, program
        assert ast.unparse(main.returns) == "dict[str, float]", program


def test_ratios_that_fell_by_a_fifth_or_are_missing_are_shown(run: dict[str, Any]) -> None:
    earlier = {"fell": 10.0, "noise": 10.0, "rose": 10.0, "missing": 10.0}
    fell, missing = run["slower"](earlier, {"fell": 7.9, "noise": 8.1, "rose": 30.0, "new": 1.0})
    assert "fell" in fell
    assert "missing" in missing


def test_one_benchmark_writes_its_ratios(tmp_path: Path) -> None:
    out = tmp_path / "ratios.json"
    program = tmp_path / "constant.py"
    program.write_text("def main(): return {'a thing': 2.5}\n")
    command = [sys.executable, str(BENCHMARKS / "run.py"), "--one", str(program), "--out", str(out)]
    subprocess.run(command, check=True)
    assert json.loads(out.read_text()) == {"a thing": 2.5}
