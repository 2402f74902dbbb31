"""The exported folder is a valid Arduino library, and its example compiles."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import building
import pytest
from random_chains import random_image, random_stream
from test_model_parity import learned

import numpy as np
from firstcontact.chain import Image
from firstcontact.contact import pretrained_detector
from firstcontact.core import FINGERTIP_RATE
from firstcontact.export import Trained
from firstcontact.export import _c_library as c_library
from firstcontact.models import ESTIMATORS, Task, shipped_model

STUB = Path(__file__).parents[2] / "firmware" / "teensy" / "stub"


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("library")
    model = learned(ESTIMATORS.default, Task.REGRESSION)
    anytime = compacted(conditioned(), plain(touches(60, 1)), 8)
    c_library.write(Trained((model,), trained(DETECTORS.default), anytime), folder)
    return folder


def test_it_is_a_library(library: Path) -> None:
    properties = (library / "library.properties").read_text(encoding="utf-8")
    conditioned_on = dict(line.split("=", 1) for line in properties.splitlines())
    assert {"name", "version", "architectures"} <= set(conditioned_on)
    names = {path.name for path in (library / "src").iterdir()}
    for path in (library / "src").iterdir():
        assert set(re.findall(r'#include "(.*)"', path.read_text(encoding="utf-8"))) <= names


def test_no_file_of_it_asks_for_memory_or_calls_itself(library: Path) -> None:
    for path in (library / "src").glob("*.c"):
        assert not re.search(r"\b(malloc|calloc|realloc|free|alloca)\b", path.read_text("utf-8"))


def test_its_example_compiles_against_the_stub(
    request: pytest.FixtureRequest, library: Path, tmp_path: Path
) -> None:
    if not shutil.which(f"{building.ARM}g++"):
        pytest.skip(f"{request.node.name}: gcc-arm-none-eabi is not installed")
    building.run(
        [f"{building.ARM}g++", "-std=gnu++17", *building.WARN[1:], *building.PLAIN, *building.M7,
         "-nostdinc++", "-fno-exceptions", "-fno-rtti", f"-I{STUB}", f"-I{library / 'src'}",
         "-include", "Arduino.h", "-x", "c++", "-c", str(library / "examples/cycles/cycles.ino"),
         "-o", str(tmp_path / "cycles.o")]
    )  # fmt: skip
