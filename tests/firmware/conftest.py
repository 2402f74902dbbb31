"""The firmware is built once, out of the tree."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from firmware_build import make, need_arm
from firmware_core import Core
from hand import models

# What measures C and runs it lies beside the firmware.
sys.path.append(str(Path(__file__).parents[2] / "firmware" / "measure"))


@pytest.fixture(scope="session")
def build(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("firmware")


@pytest.fixture(scope="session")
def core(build: Path) -> Core:
    """The portable core as a shared library."""
    make(build, "library")
    return Core(build / "libfirstcontact.so")


@pytest.fixture(scope="session")
def program(build: Path) -> Path:
    """The device as a program of this machine."""
    make(build, "native")
    return build / "firstcontact-device"


@pytest.fixture(scope="session")
def strict_program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same, which dies of the first thing that C leaves undefined."""
    build = tmp_path_factory.mktemp("strict")
    make(build, "native", "SANITIZE=address,undefined,float-cast-overflow")
    return build / "firstcontact-device"


@pytest.fixture(scope="session")
def hand_models(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Folders of two models for a hand that answers by itself."""
    return models(tmp_path_factory.mktemp("models"))


@pytest.fixture
def image(request: pytest.FixtureRequest, build: Path) -> Path:
    """The firmware of the emulated board."""
    need_arm(request, "arm-none-eabi-gcc", "qemu-system-arm")
    make(build, "arm")
    return build / "mps2-an500.elf"
