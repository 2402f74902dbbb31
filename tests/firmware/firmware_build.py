"""Building the firmware, and what is skipped where it cannot be built."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

FIRMWARE = Path(__file__).parents[2] / "firmware"


def make(build: Path, target: str, *settings: str) -> str:
    """One of the firmware's make targets, built into ``build``; what that printed."""
    command = ["make", "--no-print-directory", "-C", str(FIRMWARE), target, f"BUILD={build}"]
    command += settings
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
    return done.stdout


def need(what: str, *programs: str) -> None:
    """Skip what needs a program that is missing."""
    missing = [program for program in programs if shutil.which(program) is None]
    if missing:
        pytest.skip(f"{what}: not installed: {', '.join(missing)} (docs/reference/firmware.md)")


def need_arm(request: pytest.FixtureRequest, *programs: str) -> None:
    """Skip a test, by its name, where a program or the C library for the Cortex-M7 is missing."""
    missing = [program for program in programs if shutil.which(program) is None]
    if not missing:
        # The compiler repeats a name that it does not find.
        command = ["arm-none-eabi-gcc", "-print-file-name=nano.specs"]
        found = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
        missing = ["newlib for arm-none-eabi"] if found == "nano.specs" else []
    if missing:
        pytest.skip(
            f"{request.node.name}: not installed: {', '.join(missing)} (docs/reference/firmware.md)"
        )
