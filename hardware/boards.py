"""Reader of the committed KiCad boards, which compares them with the table of parts.

It does not need KiCad.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from circuit import FINGERS, TEENSY, Kind, Part, fingertip_parts, parts
from project import net_name
from schematic import read_nets
from sexpr import all_of, numbers, one_of, parse, property_of

FOLDER = Path(__file__).resolve().parent / "boards"
#: Header in which the firmware assigns the Teensy's pins.
PINS = FOLDER.parents[1] / "firmware/teensy/firstcontact/pins.h"
#: Parts of each board by its name.
BOARDS = {"amplifier": parts(), "fingertip": fingertip_parts()}
#: Kinds of parts that a machine places. Connector and sockets are soldered by hand.
SMD = (Kind.RESISTOR, Kind.CAPACITOR, Kind.DIODES, Kind.AMPLIFIER)


class Placed(NamedTuple):
    """Part on a board, as the board's file states it."""

    value: str
    footprint: str
    at: tuple[float, float, float]
    """Position on KiCad's sheet and angle."""
    nets: dict[str, set[str]]
    """Nets of each pad: several if pads have the same number."""


def read_board(file: Path) -> dict[str, Placed]:
    """Return the parts of a board file by reference, such as "R1". Holes are left out."""
    found = {}
    for footprint in all_of(parse(file.read_text("utf-8")), "footprint"):
        nets: dict[str, set[str]] = {}
        for pad in all_of(footprint, "pad"):
            for net in all_of(pad, "net"):
                nets.setdefault(str(pad[1]), set()).add(str(net[2]))
        x, y, angle = (*numbers(one_of(footprint, "at")), 0.0)[:3]
        if not footprint[1].startswith("MountingHole:"):
            found[property_of(footprint, "Reference")] = Placed(
                property_of(footprint, "Value"), footprint[1], (x, y, angle), nets
            )
    return found


def expected_nets(part: Part) -> dict[str, set[str]]:
    """Return the nets of a part's pads by pad name, according to the table of parts."""
    return {pin: {net_name(net)} for pin, net in part.pins.items()}


def differences(folder: Path, name: str, table: Iterable[Part]) -> list[str]:
    """Return a sentence for each difference of a board or its schematic from the table of parts."""
    found = []
    board = read_board(folder / name / f"{name}.kicad_pcb")
    symbols = read_symbols(folder / name / f"{name}.kicad_sch")
    nets = read_nets(folder / name / f"{name}.kicad_sch")
    expected = {part.reference: part for part in table}
    for where, references in (("board", set(board)), ("schematic", set(symbols))):
        for reference in sorted(references ^ set(expected)):
            found.append(
                f"{reference} is only in the {'table' if reference in expected else where}"
            )
    for reference, part in expected.items():
        if reference in board:
            placed = board[reference]
            if (placed.value, placed.footprint) != (part.label, part.footprint):
                found.append(f"{reference} on the board is {placed.value}, {placed.footprint}")
            if placed.nets != expected_nets(part):
                found.append(f"{reference} on the board has the nets {placed.nets}")
        if symbols.get(reference) != (part.label, part.footprint, part.number):
            found.append(f"{reference} in the schematic is {symbols.get(reference)}")
        for pin, net in part.pins.items():
            if nets.get(f"{reference}.{pin}") != net:
                found.append(
                    f"{reference}.{pin} in the schematic is {nets.get(f'{reference}.{pin}')}"
                )
    return found


def read_pins(file: Path = PINS) -> dict[str, str]:
    """Return the net of each pin of the Teensy, according to the firmware's header."""
    nets = {}
    pattern = r"(\w+)_PIN\S+ = \{(.*)\};"
    for name, values in re.findall(pattern, file.read_text("utf-8")):
        pins = [
            int(number) + 14 * (letter == "A")
            for letter, number in re.findall(r"(A?)(\d+)", values)
        ]
        each = len(pins) // len(FINGERS)
        for place, pin in enumerate(pins):
            finger, line = FINGERS[place // each], place % each
            kind = name.lower().replace("piezo", "adc")
            nets[str(pin)] = f"{kind}_{finger}" if each == 1 else f"{finger}_{kind}_{line}"
    return nets


def pin_differences(file: Path = PINS) -> list[str]:
    """Return a sentence for each pin whose net in the firmware's header differs from the table."""
    header = read_pins(file)
    return [
        f"pin {pin} is {header.get(pin)} in {file.name}, and {TEENSY.get(pin)} on the board"
        for pin in sorted({*header, *(p for p in TEENSY if p.isdigit())}, key=int)
        if header.get(pin) != TEENSY.get(pin)
    ]


def read_symbols(file: Path) -> dict[str, tuple[str, str, str]]:
    """Return (value, footprint, part number) of each symbol of a schematic, by reference."""
    return {
        property_of(symbol, "Reference"): (
            property_of(symbol, "Value"), property_of(symbol, "Footprint"),
            property_of(symbol, "MPN"),
        )
        for symbol in all_of(parse(file.read_text("utf-8")), "symbol")
        if not property_of(symbol, "Reference").startswith("#")
    }  # fmt: skip


def placed() -> set[str]:
    """Return the references of the parts that a machine places on the amplifier board."""
    return {part.reference for part in parts() if part.kind in SMD}
