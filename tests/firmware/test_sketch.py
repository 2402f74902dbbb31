"""The Teensy's sketch compiles, and what is generated or told about it is so."""

from __future__ import annotations

import re
import runpy
import subprocess
from pathlib import Path

import pytest
from firmware_build import FIRMWARE, make, need_arm

#: What the sketch may leave to Teensyduino, as the stub declares it, and to the C library.
TEENSYDUINO = (
    "IntervalTimer::", "usb_serial_class::", "HardwareSerial::", "Print::", "Serial",
    "F_CPU_ACTUAL", "eeprom_", "eepromemu_flash_", "_flashimagelen", "analogRead", "digital",
    "pinMode", "delay", "micros",
)  # fmt: skip
LIBRARY = {"__aeabi_uldivmod", "memcmp", "memcpy", "memmove", "memset", "sqrt", "strlen"}


@pytest.mark.parametrize("board", ["TEENSY40", "TEENSY41"])
def test_the_sketch_compiles_against_the_stub_and_fits(
    request: pytest.FixtureRequest, tmp_path: Path, board: str
) -> None:
    need_arm(request, "arm-none-eabi-gcc", "arm-none-eabi-g++")
    sizes = make(tmp_path, "sketch", f"BOARD={board}").splitlines()[-1]
    command = ["arm-none-eabi-nm", "-u", "-C", str(tmp_path / "firstcontact.ino.o")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    missing = {line.split()[1].split("(")[0] for line in done.stdout.splitlines()}
    unknown = {name for name in missing if not name.startswith(TEENSYDUINO)}
    assert unknown <= LIBRARY
    flash, one, two = (int(text) for text in re.findall(r" (\d+)", sizes))
    assert flash < 64 * 1024
    assert one < 352 * 1024  # of 512, as is RAM2: Teensyduino and the user's own hand need some
    assert two < 192 * 1024


def test_the_sketchs_folder_has_all_that_the_arduino_ide_wants(tmp_path: Path) -> None:
    make(tmp_path, "sketch-folder")
    there = {path.name for path in (tmp_path / "firstcontact").iterdir()}
    assert "firstcontact.ino" in there
    own = {path.name for path in (FIRMWARE / "teensy/firstcontact").iterdir()}
    shared = {path.name for room in ("core", "answers") for path in (FIRMWARE / room).iterdir()}
    assert own | shared <= there
    assert all(name.startswith("fc_") for name in there - own)
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
