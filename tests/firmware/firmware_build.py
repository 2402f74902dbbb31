"""Building the firmware, and what is skipped where it cannot be built."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

FIRMWARE = Path(__file__).parents[2] / "firmware"


def make(build: Path, target: str, *settings: str) -> None:
    """One of the firmware's make targets, built into ``build``."""
    command = ["make", "-C", str(FIRMWARE), target, f"BUILD={build}", *settings]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"


def need(*programs: str) -> None:
    """Skip where a program of the emulator or of the ARM tool chain is missing."""
    missing = [program for program in programs if shutil.which(program) is None]
    if missing:
        pytest.skip(f"not installed: {', '.join(missing)} (docs/reference/firmware.md)")
