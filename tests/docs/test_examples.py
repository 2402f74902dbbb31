"""Every example runs without a warning."""

import json
import subprocess
import sys
from pathlib import Path

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
