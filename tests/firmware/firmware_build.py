"""Functions that build the firmware, and skip tests where it cannot be built."""

import shutil
import subprocess
from pathlib import Path

import pytest

FIRMWARE = Path(__file__).parents[2] / "firmware"


def make(build: Path, target: str, *settings: str) -> str:
    """Build one of the firmware's make targets into ``build`` and return the output."""
    command = ["make", "--no-print-directory", "-C", str(FIRMWARE), target, f"BUILD={build}"]
    command += settings
    process = subprocess.run(command, capture_output=True, text=True)
    assert process.returncode == 0, f"{process.stdout}\n{process.stderr}"
    return process.stdout


def need(subject: str, *programs: str) -> None:
    """Skip the test if a program is missing."""
    missing = [program for program in programs if shutil.which(program) is None]
    if missing:
        pytest.skip(f"{subject}: not installed: {', '.join(missing)} (docs/reference/firmware.md)")


def need_arm(request: pytest.FixtureRequest, *programs: str) -> None:
    """Skip the test if a program or the C library for the Cortex-M7 is missing."""
    missing = [program for program in programs if shutil.which(program) is None]
    if not missing:
        # The compiler prints an unknown name unchanged.
        command = ["arm-none-eabi-gcc", "-print-file-name=nano.specs"]
        path = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
        missing = ["newlib for arm-none-eabi"] if path == "nano.specs" else []
    if missing:
        pytest.skip(
            f"{request.node.name}: not installed: {', '.join(missing)} (docs/reference/firmware.md)"
        )
