"""Markdown tables of the resistances that a multimeter should read on the boards."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace

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


def resistance(a: str, b: str, joined: Collection[str] = ()) -> float:
    """Return the resistance between two nets of the amplifier board, ohm, by its resistors only.

    Nets that are ``joined`` count as one.
    """
    a, b = ("joined" if net in joined else net for net in (a, b))
    if a == b:
        return 0.0
    resistors = [
        replace(part, pins={n: "joined" if net in joined else net for n, net in part.pins.items()})
        for part in PARTS.values()
        if part.kind is Kind.RESISTOR
    ]
    resistors = [part for part in resistors if len(set(part.pins.values())) == 2]
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
    """Return the resistance that the multimeter shows between two nets, as text."""
    return _ohms(resistance(a, b))


def through_u1(a: str, b: str) -> str:
    """Return the range of the resistance between two nets once U1 is soldered, as text.

    U1 may connect its pins by any resistance.
    """
    least, most = resistance(a, b, set(PARTS["U1"].pins.values())), resistance(a, b)
    return (
        "the same"
        if a == b or least > 0.97 * most or math.isinf(least)
        else f"{_ohms(least)} to {_ohms(most)}"
    )


def _ohms(value: float) -> str:
    if math.isinf(value):
        return "open"
    return f"{value:.3g} Ω" if value < 1e3 else f"{value / 1e3:.3g} kΩ"


def _spot(finger: str, name: str) -> tuple[str, str]:
    """Return (text, net) of a place to touch on the board, given its name in ``PLACES``."""
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
    """Return a table of resistances: before U1 is soldered, and afterwards."""
    shared = [("3V3", "3v3"), ("1.65V", "vref")]
    rows = [[(f"{name} and GND", net, "gnd")] * 2 for name, net in shared]
    for first, second in MEASURED:
        pairs = [(_spot(f, first), _spot(f, second)) for f in FINGERS]
        rows.append([(f"{a} and {b}", net, other) for (a, net), (b, other) in pairs])
    connectors = [PARTS[f"J{n}"] for n, _ in enumerate(FINGERS, 1)]
    for pin, wire in enumerate(CABLE, 1):
        if wire not in ("gnd", "disc"):
            nets = [j.pins[str(pin)] for j in connectors]
            ends = [net.replace("pad", "strip").replace("line", "row") for net in nets]
            rows.append([
                (f"{j.reference} pin {pin} and {_teensy(end)}", net, end)
                for j, net, end in zip(connectors, nets, ends, strict=True)
            ])  # fmt: skip
    for pin in range(1, len(CABLE)):
        rows.append([
            (f"{j.reference} pins {pin} and {pin + 1}", j.pins[str(pin)], j.pins[str(pin + 1)])
            for j in connectors
        ])  # fmt: skip
    return _table(rows)


def _table(rows: list[list[tuple[str, str, str]]]) -> str:
    """Return a Markdown table of the rows. Raise ValueError if both fingers read differently.

    A row has (place, net, net) for the index finger and for the thumb.
    """
    cells = []
    for index, thumb in rows:
        values = [(reading(*nets), through_u1(*nets)) for _, *nets in (index, thumb)]
        if values[0] != values[1]:
            raise ValueError(f"the fingers differ: {index}, {thumb}")
        (a, *_), (b, *_) = index, thumb
        cells.append((a, "the same" if a == b else b, *values[0]))
    return markdown_table("index | thumb | should read | once U1 is soldered", cells)
