"""Programs that see the example plug-in."""

from __future__ import annotations

import subprocess
import sys


def run(environment: dict[str, str], *arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *map(str, arguments)], env=environment, capture_output=True, text=True
    )


def firstcontact(
    environment: dict[str, str], *arguments: object
) -> subprocess.CompletedProcess[str]:
    return run(environment, "-m", "firstcontact.cli.main", *arguments)
