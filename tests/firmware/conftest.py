"""Fixtures that build the firmware once, outside the source tree."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from firmware_build import make, need_arm
from firmware_core import Core
from hand import models

# The modules that measure exported C are part of the firmware.
sys.path.append(str(Path(__file__).parents[2] / "firmware" / "measure"))


@pytest.fixture(scope="session")
def build(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("firmware")


@pytest.fixture(scope="session")
def core(build: Path) -> Core:
    """Build the portable core as a shared library."""
    make(build, "library")
    return Core(build / "libfirstcontact.so")


@pytest.fixture(scope="session")
def program(build: Path) -> Path:
    """Build the device as a program of this machine."""
    make(build, "native")
    return build / "firstcontact-device"


@pytest.fixture(scope="session")
def strict_program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the same program with sanitizers, which stop it at undefined behaviour."""
    build = tmp_path_factory.mktemp("strict")
    make(build, "native", "SANITIZE=address,undefined,float-cast-overflow")
    return build / "firstcontact-device"


@pytest.fixture(scope="session")
def hand_models(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Write two folders of models for predictions on the device."""
    return models(tmp_path_factory.mktemp("models"))


@pytest.fixture
def image(request: pytest.FixtureRequest, build: Path) -> Path:
    """Build the firmware of the emulated board."""
    need_arm(request, "arm-none-eabi-gcc", "qemu-system-arm")
    make(build, "arm")
    return build / "mps2-an500.elf"
