"""Compilation of the Teensy's sketch, its generated headers and the pins in the docs."""

import re
import runpy
import subprocess
from pathlib import Path

import pytest
from firmware_build import FIRMWARE, make, need_arm

#: Symbols that Teensyduino provides, as the stub declares them; LIBRARY: those of the C library.
TEENSYDUINO = (
    "IntervalTimer::", "usb_serial_class::", "HardwareSerial::", "Print::", "Serial",
    "F_CPU_ACTUAL", "eeprom_", "eepromemu_flash_", "_flashimagelen", "analogRead", "digital",
    "pinMode", "delay", "micros",
)  # fmt: skip
LIBRARY = {
    "__aeabi_l2d", "__aeabi_ldivmod", "__aeabi_uldivmod", "memcmp", "memcpy",
    "memmove", "memset", "sqrt", "strlen",
}  # fmt: skip


@pytest.mark.parametrize("board", [pytest.param("TEENSY40", marks=pytest.mark.slow), "TEENSY41"])
def test_sketch_compiles_against_the_stub_and_fits(
    request: pytest.FixtureRequest, tmp_path: Path, board: str
) -> None:
    need_arm(request, "arm-none-eabi-gcc", "arm-none-eabi-g++")
    sizes = make(tmp_path, "sketch", f"BOARD={board}").splitlines()[-1]
    command = ["arm-none-eabi-nm", "-u", "-C", str(tmp_path / "firstcontact.ino.o")]
    process = subprocess.run(command, capture_output=True, text=True, check=True)
    missing = {line.split()[1].split("(")[0] for line in process.stdout.splitlines()}
    unknown = {name for name in missing if not name.startswith(TEENSYDUINO)}
    assert unknown <= LIBRARY
    flash, one, two = (int(text) for text in re.findall(r" (\d+)", sizes))
    assert flash < 64 * 1024
    assert one < 384 * 1024  # of 512 KiB, as in RAM2: Teensyduino and the user's code need some
    assert two < 192 * 1024
    page = (FIRMWARE.parent / "docs/reference/firmware.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (?:flash: code|RAM\d).* ([\d,]+) \|$", page, re.MULTILINE)
    code, state, model, slots = (int(number.replace(",", "")) for number in rows)
    assert [flash, one, two] == pytest.approx([code, state + model, slots], rel=0.02)


def test_sketch_folder_has_all_files_for_the_arduino_ide(tmp_path: Path) -> None:
    make(tmp_path, "sketch-folder")
    files = {path.name for path in (tmp_path / "firstcontact").iterdir()}
    assert "firstcontact.ino" in files
    sources = {path.name for path in (FIRMWARE / "teensy/firstcontact").iterdir()}
    shared = {path.name for room in ("core", "predictor") for path in (FIRMWARE / room).iterdir()}
    assert sources | shared <= files
    assert all(name.startswith("fc_") for name in files - sources)
    for name in files:
        text = (tmp_path / "firstcontact" / name).read_text(encoding="utf-8")
        ours = set(re.findall(r'#include "(.*)"', text))
        assert ours <= files, name


def test_layout_in_c_equals_pythons() -> None:
    script = runpy.run_path(str(FIRMWARE / "write_layout.py"))
    assert script["PAGE"].read_text(encoding="utf-8") == script["text"]()


def test_how_to_has_the_pins_of_the_sketch() -> None:
    text = (FIRMWARE / "teensy/firstcontact/pins.h").read_text(encoding="utf-8")
    pins = set()
    for values in re.findall(r"= \{(.*)\};", text):
        for pin in re.findall(r"A?\d+", values):
            pins.add(int(pin[1:]) + 14 if pin[0] == "A" else int(pin))
    page = FIRMWARE.parent / "docs/reference/fingertip.md"
    section = page.read_text(encoding="utf-8").split("## The pins")[1].split("## ")[0]
    cells = re.findall(r"^\| (\d.*?) \|", section, re.MULTILINE)
    numbers = [int(text) for cell in cells for text in re.findall(r"(?<!A)\b\d+", cell)]
    assert len(pins) == 14
    assert sorted(numbers) == sorted(pins)


def test_teensyduino_that_keeps_the_pads_keeper_on_is_refused(
    request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    need_arm(request, "arm-none-eabi-gcc", "arm-none-eabi-g++")
    with pytest.raises(AssertionError, match=r"Teensyduino is older than 1\.59"):
        make(tmp_path, "sketch", "TEENSYDUINO=158")
