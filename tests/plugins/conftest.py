"""Example plug-in, installed in an environment."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from installed import firstcontact

from shared_runs import made_once

EXAMPLE = Path(__file__).parent / "example"


@pytest.fixture(scope="session")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Environment variables with the example installed, for commands only."""

    def install(site: Path) -> None:
        # Building leaves files behind.
        source = shutil.copytree(EXAMPLE, tmp_path_factory.mktemp("plugin") / "source")
        pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
        options = ("--no-deps", "--no-build-isolation", "--no-index", "--target", site)
        subprocess.run([*pip, *options, source], check=True)

    site = made_once(tmp_path_factory, "plugin-site", install)
    paths = [str(site), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "COLUMNS": "200"}


@pytest.fixture(scope="session")
def pinches(environment: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of simulated pinches."""

    def make(out: Path) -> None:
        sizes = ("--pinches-per-block", 20, "--pinches-per-object", 4)
        process = firstcontact(environment, "simulate", "--out", out, *sizes)
        assert process.returncode == 0, process.stderr

    return made_once(tmp_path_factory, "plugin-pinches", make)


@pytest.fixture(scope="session")
def model(
    environment: dict[str, str], pinches: Path, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """Model with the estimator and the detector of the example."""

    def make(out: Path) -> None:
        options = ("--estimator", "loudness", "--detector-type", "energy", "--contacts", "detected")
        process = firstcontact(environment, "train", pinches, "--out", out, *options)
        assert process.returncode == 0, process.stderr
        assert "loudness (regression), 15 ms: " in process.stdout
        assert "detector energy:" in process.stdout

    return made_once(tmp_path_factory, "plugin-model", make)
