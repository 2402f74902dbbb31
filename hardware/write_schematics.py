"""Write the KiCad schematics of both boards from the table.

python hardware/write_schematics.py  # into hardware/boards
"""

from __future__ import annotations

import argparse
from pathlib import Path

from circuit import CABLE, COLUMNS, ROWS, fingertip_parts, parts
from project import write_projects
from schematic import Label, Put, Sheet, Wire, write_schematic
from symbols import FLAG

#: Distance of the ground's symbol from a connector's middle, beyond the names of its nets.
GROUND_X = 11.0


def _cable_wires(reference: str, corner: tuple[float, float], ground: float) -> list[Wire]:
    """Return the wires at a cable's connector: short ones to labels, long ones of the ground."""
    x, y = corner
    first, last = (n for n, wire in enumerate(CABLE, 1) if wire == "gnd")
    return [
        *(Wire((f"{reference}.{n}", (x + 4, None))) for n, w in enumerate(CABLE, 1) if w != "gnd"),
        Wire((f"{reference}.{first}", (x + ground, None), (None, y + 6))),
        Wire((f"{reference}.{last}", (x + ground, None))),
    ]


def _finger(place: int, finger: str, x: float, y: float) -> Sheet:
    """Return the plan of one finger's circuit. Its upper left corner is at ``x`` and ``y``."""
    n, unit = 10 * place, place
    plus, minus, out = (("3", "2", "1"), ("5", "6", "7"))[place - 1]
    r = [f"R{n + k}" for k in range(9)]
    rows = [f"R{n + 20 + k}" for k in range(ROWS)]
    j, d, c = f"J{place}", f"D{n}", f"C{n}"
    puts = (
        Put(j, (x, y + 5)),
        Put(r[0], (x + 17, y + 3.5)), Put(r[1], (x + 22, y + 2), 90),
        Put(d, (x + 29, y + 2)), Put(r[2], (x + 34, y + 2), 90),
        Put("U1", (x + 43, y + 3), unit=unit),
        Put(r[3], (x + 43, y + 7), 270), Put(r[4], (x + 39, y + 8.5)),
        Put(r[5], (x + 51, y + 3), 90), Put(c, (x + 54, y + 4.5)),
        Put(r[6], (x + 3, y + 13), 90),
        Put(r[7], (x + 15, y + 12)), Put(r[8], (x + 25, y + 12)),
        *(Put(name, (x + 44, y + 12 + 2 * k), 90) for k, name in enumerate(rows)),
    )  # fmt: skip
    wires = [
        Wire(((x + 13, y + 2), f"{r[0]}.1", f"{r[1]}.1")),
        Wire((f"{r[1]}.2", f"{d}.3", f"{r[2]}.1")),
        Wire((f"{r[2]}.2", f"U1.{plus}")),
        Wire((f"U1.{minus}", (x + 39, None), f"{r[4]}.1")),
        Wire((f"{r[4]}.1", f"{r[3]}.2")),
        Wire((f"{r[3]}.1", (x + 47, None), (None, y + 3), f"U1.{out}")),
        Wire(((x + 47, y + 3), f"{r[5]}.1")),
        Wire((f"{r[5]}.2", f"{c}.1", (x + 56, None))),
        Wire((f"{r[6]}.1", (x + 0.5, None))), Wire((f"{r[6]}.2", (x + 5.5, None))),
        *_cable_wires(j, (x, y), GROUND_X),
        *(
            Wire((f"{r[7 + k]}.1", (None, y + 9.5), (x + 15.5 + 10 * k, None)))
            for k in range(COLUMNS)
        ),
        *(
            Wire((f"{name}.{pin}", (x + 44 + side, None)))
            for name in rows
            for pin, side in ((1, -2.5), (2, 2.5))
        ),
    ]  # fmt: skip
    nets = {part.reference: part for part in parts()}[j].pins
    labels = [
        *(Label(net, (x + 4, y + int(pin))) for pin, net in nets.items() if net != "gnd"),
        Label("gnd", (x + GROUND_X, y + 6)),
        Label(f"disc_{finger}", (x + 13, y + 2)), Label("vref", f"{r[0]}.2", 270),
        Label(f"clamp_{finger}", (x + 23.6, y + 2)), Label(f"in_{finger}", (x + 35.6, y + 2)),
        Label("3v3", f"{d}.2"), Label("gnd", f"{d}.1"), Label("vref", f"{r[4]}.2", 270),
        Label(f"fb_{finger}", (x + 39, y + 7), 180), Label(f"out_{finger}", (x + 47, y + 7)),
        Label("gnd", f"{c}.2"), Label(f"adc_{finger}", (x + 56, y + 3)),
        Label(f"pad_{finger}", (x + 0.5, y + 13), 180), Label(f"strip_{finger}", (x + 5.5, y + 13)),
        *(Label(f"{finger}_column_{k}", (x + 15.5 + 10 * k, y + 9.5)) for k in range(COLUMNS)),
        *(Label("gnd", f"{r[7 + k]}.2") for k in range(COLUMNS)),
        *(Label(f"{finger}_line_{k}", (x + 41.5, y + 12 + 2 * k), 180) for k in range(ROWS)),
        *(Label(f"{finger}_row_{k}", (x + 46.5, y + 12 + 2 * k)) for k in range(ROWS)),
    ]  # fmt: skip
    return Sheet(
        "",
        "",
        puts,
        tuple(wires),
        tuple(labels),
        (("thumb" if finger == "thumb" else "index finger", (x - 2, y - 2.5)),),
    )


def amplifier_sheet() -> Sheet:
    """Return the plan of the amplifier board's schematic."""
    fingers = [_finger(1, "index", 10, 8), _finger(2, "thumb", 10, 30)]
    x, y = 10.0, 54.0
    puts = (
        Put("R1", (x, y)), Put("R2", (x, y + 3)), Put("C1", (x + 6, y + 3)),
        Put("U1", (x + 15, y + 2.5), unit=3), Put("U1", (x + 31, y + 2.5), unit=4),
        Put("U1", (x + 45, y + 2.5), unit=5), Put("C2", (x + 50, y + 2.5)),
        Put("TP1", (x + 60, y + 2)), Put("TP2", (x + 64, y + 2)), Put("TP3", (x + 68, y + 2)),
        Put("A1", (92, 27)),
    )  # fmt: skip
    wires = [
        Wire(("R1.2", "C1.1", "U1.10")),
        Wire(("U1.9", (x + 11, None), (None, y + 6), (x + 19, None), (None, y + 2.5), "U1.8")),
        Wire(((x + 19, y + 2.5), (x + 20, None))),
        Wire(((x + 26, y + 1.5), "U1.12")),
        Wire(("U1.13", (x + 27, None), (None, y + 6), (x + 35, None), (None, y + 2.5), "U1.14")),
        Wire(("U1.4", (x + 50, None), "C2.1")),
        Wire(("U1.11", (x + 50, None), "C2.2")),
        Wire(("TP2.1", (None, y + 3.5))),
    ]
    labels = [
        Label("3v3", "R1.1"), Label("gnd", "R2.2"), Label("gnd", "C1.2"),
        Label("half", (x + 2, y + 1.5)), Label("vref", (x + 20, y + 2.5)),
        Label("half", (x + 26, y + 1.5), 180), Label("unused", (x + 28.5, y + 6)),
        Label("3v3", "U1.4"), Label("gnd", "U1.11"),
        Label("3v3", "TP1.1", 180), Label("vref", (x + 64, y + 3.5), 270), Label("gnd", "TP3.1"),
        Label("3v3", "A1.3V3"), Label("gnd", "A1.GND"),
    ]  # fmt: skip
    teensy = next(part for part in parts() if part.reference == "A1").pins
    for pin, net in teensy.items():
        if pin.isdigit():
            is_left = int(pin) >= 14
            end = 84.5 if is_left else 99.5
            wires.append(Wire((f"A1.{pin}", (end, None))))
            row = 27 - (17.5 - int(pin) if is_left else 5.5 - int(pin))
            labels.append(Label(net, (end, row), 180 if is_left else 0))
    return Sheet(
        "amplifier", "Amplifier for two fingertips",
        (*fingers[0].puts, *fingers[1].puts, *puts),
        (*fingers[0].wires, *fingers[1].wires, *wires),
        (*fingers[0].labels, *fingers[1].labels, *labels),
        (
            *fingers[0].notes, *fingers[1].notes,
            ("reference of 1.65 V", (x - 2, y - 4)), ("not used", (x + 27, y - 1)),
            ("supply", (x + 45, y - 4)), ("test points", (x + 60, y - 4)),
        ),
    )  # fmt: skip


def fingertip_sheet() -> Sheet:
    """Return the plan of the fingertip board's schematic."""
    x, y = 45.0, 14.0
    puts = [Put("J1", (17, 17)), Put("BZ1", (17, 32)), Put("E1", (30, 32))]
    wires = [
        *_cable_wires("J1", (17, 12), 9),
        Wire(("BZ1.1", (None, 29.5), (17.5, None))),
        Wire(("BZ1.2", (None, 34.5), (21, None))),
        Wire(("E1.1", (32.5, None))),
    ]
    labels = [
        *(Label(wire, (21, 12 + pin)) for pin, wire in enumerate(CABLE, 1) if wire != "gnd"),
        Label("gnd", (26, 18)), Label("disc", (17.5, 29.5)), Label("gnd", (17, 34.5)),
        Label(FLAG, (21, 34.5)), Label("strip", (32.5, 32)),
    ]  # fmt: skip
    for row in range(ROWS):
        wires.append(Wire(((x, y + 6 * row), *(f"T{COLUMNS * row + c}.1" for c in range(COLUMNS)))))
        labels.append(Label(f"row_{row}", (x, y + 6 * row), 180))
    for column in range(COLUMNS):
        line = x + 10 + 10 * column
        wires.append(Wire(((line, y - 3), (None, y + 15))))
        labels.append(Label(f"column_{column}", (line, y - 3), 90))
        for row in range(ROWS):
            name = f"T{COLUMNS * row + column}"
            puts.append(Put(name, (line - 4, y + 1.5 + 6 * row)))
            wires.append(Wire((f"{name}.2", (line, None))))
    return Sheet(
        "fingertip", "Board of the fingertip", tuple(puts), tuple(wires), tuple(labels),
        (
            ("cable", (14, 8)), ("taxels under Velostat", (x - 4, 7)),
            ("disc, land on ground", (11, 26)), ("contact strip", (27, 26)),
        ),
        "A5",
    )  # fmt: skip


def main() -> None:
    """Write the schematics of both boards."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "boards")
    folder = parser.parse_args().out
    write_projects(folder)
    for sheet, table in ((amplifier_sheet(), parts()), (fingertip_sheet(), fingertip_parts())):
        write_schematic(sheet, table, folder / sheet.name / f"{sheet.name}.kicad_sch")


if __name__ == "__main__":
    main()
