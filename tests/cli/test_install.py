"""The installed package, in an environment with the base install only."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the ``bin`` folder of a fresh environment after ``pip install WHEEL``."""
    folder = tmp_path_factory.mktemp("base")
    source = folder / "source"  # building leaves files behind, and not in the checkout
    shutil.copytree(ROOT / "src", source / "src", ignore=shutil.ignore_patterns("*.egg-info"))
    for file in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / file, source)
    pip = ["-m", "pip", "--disable-pip-version-check", "--quiet"]
    wheel = [sys.executable, *pip, "wheel", "--no-deps", "--wheel-dir", folder, source]
    subprocess.run(wheel, check=True, cwd=folder)
    (built,) = folder.glob("firstcontact-*.whl")
    venv.create(folder / "venv", with_pip=True, symlinks=True)
    scripts = folder / "venv" / "bin"
    install = [scripts / "python", *pip, "install", "-c", ROOT / "constraints.txt", built]
    subprocess.run(install, check=True, cwd=folder)
    return scripts


def run(scripts: Path, *arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    return subprocess.run(
        [scripts / "firstcontact", *arguments],
        capture_output=True,
        text=True,
        cwd=cwd,
        env=environment,
    )


def test_help_needs_no_extra(base: Path, tmp_path: Path) -> None:
    process = run(base, "--help", cwd=tmp_path)
    assert process.returncode == 0, process.stderr
    assert "simulate" in process.stdout


@pytest.mark.parametrize(
    ("arguments", "extra"),
    [
        (["simulate", "--out", "out"], "twin"),
        (["study", "--out", "out"], "study"),
    ],
    ids=["simulate", "study"],
)
def test_a_missing_extra_is_one_sentence_and_exit_2(
    base: Path, tmp_path: Path, arguments: list[str], extra: str
) -> None:
    process = run(base, *arguments, cwd=tmp_path)
    assert process.returncode == 2
    assert process.stderr.count("\n") == 1
    wheel, _, named = shlex.split(process.stderr.partition(": ")[2].partition(": ")[2])[
        -1
    ].partition("[")
    assert Path(wheel).suffix == ".whl"
    assert Path(wheel).is_file()
    assert named == f"{extra}]"
    assert list(tmp_path.iterdir()) == []


def test_importing_and_looking_need_no_extra(base: Path, tmp_path: Path) -> None:
    example = [base / "python", ROOT / "examples" / "own_arrays.py"]
    subprocess.run(example, check=True, cwd=tmp_path, capture_output=True)
    for arguments in (
        ["import", "own.npz", "--out", "own"],
        ["inspect", "own/000_monday.mcap"],
        ["export", "own", "--to", "csv", "--out", "own.csv"],
    ):
        process = run(base, *arguments, cwd=tmp_path)
        assert process.returncode == 0, process.stderr
