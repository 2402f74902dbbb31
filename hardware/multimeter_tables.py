"""What a multimeter should read on the boards, from the table of parts and nets."""

from __future__ import annotations

import math

import numpy as np
from circuit import CABLE, FINGERS, TEENSY, Kind, parts

from firstcontact_lab.report.tables import markdown_table

PARTS = {part.reference: part for part in parts()}
#: Where each net of a finger can be touched, on its connector, clamp, amplifier and the Teensy.
PLACES = {
    "index": {"disc": "J1.4", "clamp": "D10.3", "in": "U1.3", "fb": "U1.2", "out": "U1.1"},
    "thumb": {"disc": "J2.4", "clamp": "D20.3", "in": "U1.5", "fb": "U1.6", "out": "U1.7"},
}
#: Places that are measured, by net; ``vref`` and ``gnd`` are test points.
MEASURED = (
    ("disc", "vref"), ("disc", "gnd"), ("disc", "clamp"), ("clamp", "in"),
    ("fb", "out"), ("fb", "vref"), ("out", "adc"),
)  # fmt: skip
TEST_POINTS = {"3v3": "3V3", "vref": "1.65V", "gnd": "GND"}


def resistance(a: str, b: str) -> float:
    """Return the resistance between two nets of the amplifier board with its resistors alone."""
    resistors = [part for part in PARTS.values() if part.kind is Kind.RESISTOR]
    nets = [a]
    for net in nets:  # grows: all that is connected to a
        for part in resistors:
            if net in part.pins.values():
                nets += [other for other in part.pins.values() if other not in nets]
    if b not in nets:
        return math.inf
    laplacian = np.zeros((len(nets), len(nets)))
    for part in resistors:
        if part.pins["1"] in nets:
            i, j = (nets.index(net) for net in part.pins.values())
            laplacian[[i, j, i, j], [i, j, j, i]] += np.array([1, 1, -1, -1]) / part.value
    i, j = nets.index(a), nets.index(b)
    inverse = np.linalg.pinv(laplacian)
    return float(inverse[i, i] + inverse[j, j] - 2 * inverse[i, j])


def reading(a: str, b: str) -> str:
    """Return what the multimeter shows between two nets, in words."""
    if a == b:
        return "0 Ω"
    value = resistance(a, b)
    if math.isinf(value):
        return "open"
    return f"{value:.3g} Ω" if value < 1e3 else f"{value / 1e3:.3g} kΩ"


def _spot(finger: str, name: str) -> tuple[str, str]:
    """Return how a place is called on the board, and its net."""
    if name in TEST_POINTS:
        return TEST_POINTS[name], name
    if name == "adc":
        return _teensy(f"adc_{finger}"), f"adc_{finger}"
    reference, pin = PLACES[finger][name].split(".")
    kind = "pin" if reference[0] == "J" else "pad"
    return f"{reference} {kind} {pin}", PARTS[reference].pins[pin]


def _teensy(net: str) -> str:
    pin = next(pin for pin, other in TEENSY.items() if other == net)
    return f"Teensy {pin}" + (f" (A{int(pin) - 14})" if int(pin) >= 14 else "")


def resistors_table() -> str:
    """Return the resistances once resistors, capacitors and connectors are soldered."""
    rows = [(f"3V3 and GND: {reading('3v3', 'gnd')}",) * 2]
    rows += [(f"1.65V and GND: {reading('vref', 'gnd')}",) * 2]
    for first, second in MEASURED:
        rows.append(
            tuple(
                f"{a} and {b}: {reading(net, other)}"
                for (a, net), (b, other) in (
                    (_spot(f, first), _spot(f, second)) for f in FINGERS
                )
            )
        )  # fmt: skip
    connectors = [PARTS[f"J{n}"] for n, _ in enumerate(FINGERS, 1)]
    for pin, wire in enumerate(CABLE, 1):
        if wire not in ("gnd", "disc"):
            nets = [j.pins[str(pin)] for j in connectors]
            ends = [net.replace("pad", "strip").replace("line", "row") for net in nets]
            rows.append(
                tuple(
                    f"{j.reference} pin {pin} and {_teensy(end)}: {reading(net, end)}"
                    for j, net, end in zip(connectors, nets, ends, strict=True)
                )
            )
    for pin in range(1, len(CABLE)):
        rows.append(
            tuple(
                f"{j.reference} pins {pin} and {pin + 1}: "
                + reading(j.pins[str(pin)], j.pins[str(pin + 1)])
                for j in connectors
            )
        )
    return _table(rows)


def _table(rows: list[tuple[str, ...]]) -> str:
    """Return the rows as Markdown; each row's fingers must read the same."""
    cells = []
    for index, thumb in rows:
        (a, value), (b, other) = (cell.split(": ") for cell in (index, thumb))
        if value != other:
            raise ValueError(f"the fingers differ: {index}, {thumb}")
        cells.append((a, "the same" if a == b else b, value))
    return markdown_table("index | thumb | should read", cells)
