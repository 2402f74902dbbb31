"""The Teensy's sketch compiles, and what is generated or told about it is so."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest
from firmware_build import FIRMWARE, make, need_arm


def test_the_sketch_compiles_against_the_stub(
    request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    need_arm(request, "arm-none-eabi-gcc", "arm-none-eabi-g++")
    make(tmp_path, "sketch")
    assert (tmp_path / "firstcontact.ino.o").is_file()


def test_the_sketchs_folder_has_all_that_the_arduino_ide_wants(tmp_path: Path) -> None:
    make(tmp_path, "sketch-folder")
    there = {path.name for path in (tmp_path / "firstcontact").iterdir()}
    assert "firstcontact.ino" in there
    core = {path.name for path in (FIRMWARE / "core").iterdir()}
    assert there - core == {"firstcontact.ino", "pins.h"}
    for name in there:
        text = (tmp_path / "firstcontact" / name).read_text(encoding="utf-8")
        ours = set(re.findall(r'#include "(.*)"', text))
        assert ours <= there, name


def test_the_layout_in_c_is_the_one_of_python() -> None:
    script = runpy.run_path(str(FIRMWARE / "write_layout.py"))
    assert script["PAGE"].read_text(encoding="utf-8") == script["text"]()


def test_the_how_to_wires_the_pins_that_the_sketch_uses() -> None:
    text = (FIRMWARE / "teensy/firstcontact/pins.h").read_text(encoding="utf-8")
    pins = set()
    for values in re.findall(r"= \{(.*)\};", text):
        for pin in re.findall(r"A?\d+", values):
            pins.add(int(pin[1:]) + 14 if pin[0] == "A" else int(pin))
    page = FIRMWARE.parent / "docs/how-to/build-a-fingertip.md"
    rows = re.findall(r"^\| (\d+)(?: \(A\d\))? \|", page.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(pins) == 14
    assert sorted(map(int, rows)) == sorted(pins)


def test_the_kernels_sizes_are_the_packages() -> None:
    for name, text in runpy.run_path(str(FIRMWARE / "write_sizes.py"))["texts"]().items():
        assert (FIRMWARE / "answers" / f"fc_{name}_sizes.h").read_text(encoding="utf-8") == text
