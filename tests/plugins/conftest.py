"""Example plug-in, installed in an environment."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

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
