"""Fixtures that build the firmware once, outside the source tree."""

import sys
from pathlib import Path

import pytest
from firmware_build import make, need, need_arm
from firmware_core import Core
from hand import model_image

from firstcontact.export.hand_image import HandImage
from shared_runs import made_once

# The modules that measure exported C are part of the firmware.
sys.path.append(str(Path(__file__).parents[2] / "firmware" / "measure"))


def built(factory: pytest.TempPathFactory, name: str, target: str, *settings: str) -> Path:
    """Build a target once for all processes of the test run."""
    return made_once(factory, f"firmware-{name}", lambda folder: make(folder, target, *settings))


@pytest.fixture(scope="session")
def core(tmp_path_factory: pytest.TempPathFactory) -> Core:
    """Build the portable core as a shared library."""
    return Core(built(tmp_path_factory, "core", "library") / "libfirstcontact.so")


@pytest.fixture(scope="session")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the device as a program of this machine."""
    return built(tmp_path_factory, "native", "native") / "firstcontact-device"


@pytest.fixture(scope="session")
def strict_program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the device's program with sanitizers, which stop it at undefined behaviour."""
    sanitizers = "SANITIZE=address,undefined,float-cast-overflow"
    return built(tmp_path_factory, "strict", "native", sanitizers) / "firstcontact-device"


@pytest.fixture(scope="session")
def sketch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the Teensy's sketch with sanitizers, on a simulated board."""
    need("the Teensy's sketch on a simulated board", "c++")
    settings = ("SANITIZE=address,undefined", "CXX=c++")
    return built(tmp_path_factory, "teensy", "sketch-native", *settings) / "firstcontact-teensy"


@pytest.fixture(scope="session")
def images() -> tuple[HandImage, HandImage]:
    """Return two models for predictions on the device."""
    return model_image(1), model_image(2)


@pytest.fixture
def image(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the firmware of the emulated board."""
    need_arm(request, "arm-none-eabi-gcc", "qemu-system-arm")
    return built(tmp_path_factory, "board", "arm") / "mps2-an500.elf"
