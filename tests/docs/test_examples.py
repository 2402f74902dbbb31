"""Every example runs without a warning, and so does the program of all benchmarks."""

import ast
import json
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from pages import ROOT, fences

import forked

EXAMPLES = sorted(ROOT.glob("examples/*.py"))
NOTEBOOKS = sorted(ROOT.glob("examples/*.ipynb"))
#: It needs ROS 2; tests/test_front_door.py runs it with a stand-in for rclpy.
ELSEWHERE = ("ros_node",)


@pytest.mark.parametrize(
    "example", [pytest.param(e, id=e.stem) for e in EXAMPLES if e.stem not in ELSEWHERE]
)
def test_example_runs(example: Path, tmp_path: Path) -> None:
    process = forked.run("script", example, cwd=tmp_path, strict=True)
    assert process.returncode == 0, process.stderr
    assert process.stdout


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda p: p.stem)
def test_notebook_runs_twice(
    notebook: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("pandas")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("MPLBACKEND", "agg")
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    code = "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
    process = forked.run("code", f"{code}\n{code}", cwd=tmp_path, strict=True)
    assert process.returncode == 0, process.stderr


@pytest.mark.parametrize(
    "check", ["ruff check", "ruff format --check", pytest.param("mypy", marks=pytest.mark.slow)]
)
def test_the_typed_estimator_is_a_file_of_the_package(check: str, tmp_path: Path) -> None:
    (text,) = (f.body for f in fences(ROOT / "CONTRIBUTING.md") if "(ModelFromArrays)" in f.body)
    (path := tmp_path / "loudness.py").write_text(text, encoding="utf-8")
    settings = "--config-file" if check == "mypy" else "--config"
    command = [*check.split(), settings, str(ROOT / "pyproject.toml"), str(path)]
    process = subprocess.run([sys.executable, "-m", *command], cwd=ROOT, capture_output=True)
    assert process.returncode == 0, process.stdout.decode()


@pytest.mark.parametrize("example", [*EXAMPLES, *NOTEBOOKS], ids=lambda p: p.stem)
def test_example_is_named_in_a_page(example: Path) -> None:
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *ROOT.glob("docs/**/*.md")]
    assert any(f"examples/{example.name}" in p.read_text(encoding="utf-8") for p in pages)


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
