"""Markdown tables for the piezo disc: ways to glue it, and discs of other thickness."""

from __future__ import annotations

import math

from circuit import parts
from dimensions import NOMINAL as D
from disc import GLUINGS, PERMITTIVITY, Gluing, sensitivity
from stack import VACUUM

from firstcontact.twin.mechanics import FingerParameters
from firstcontact_lab.report.tables import markdown_table

#: Values of resistors that are sold, in each decade.
E24 = (
    10,
    11,
    12,
    13,
    15,
    16,
    18,
    20,
    22,
    24,
    27,
    30,
    33,
    36,
    39,
    43,
    47,
    51,
    56,
    62,
    68,
    75,
    82,
    91,
)
#: Thickness of discs of 10 mm, mm. A catalogue of PI Ceramic begins at 0.15 mm.
THICKNESSES = (0.15, 0.2, 0.25, 0.3)


def nearest(ohm: float) -> float:
    """Return the resistance in the series E24 whose ratio to ``ohm`` is closest to 1, ohm."""
    decade = 10 ** math.floor(math.log10(ohm)) / 10
    values = [n * decade for n in (*E24, 100)]
    return min(values, key=lambda value: abs(math.log(value / ohm)))


def gluings_table() -> str:
    """Return a table of the volts per newton for each way to glue the disc."""
    rows = []
    for words, gluing in GLUINGS.items():
        s = sensitivity(gluing)
        volts = (f"{v:.3f}".replace("-", "−") for v in (s.centre, s.middle, s.corner, s.all))
        is_positive = min(s.middle, s.corner) > 0
        deviation = f"{100 * s.spread:.0f} %" if is_positive else "turns its sign"
        rows.append((words, *volts, deviation, f"{1e9 * s.capacitance:.1f} nF"))
    return markdown_table(
        "glue | middle, V/N | middle row | corner | all six | deviation | capacitance", rows
    )


def discs_table() -> str:
    """Return a table of the resistors to solder for discs of other thickness."""
    values = {part.reference: part.value for part in parts()}
    finger = FingerParameters()
    wanted = finger.piezo_volts_per_newton * finger.gain
    rows = []
    for thickness in THICKNESSES:
        s = sensitivity(Gluing(disc=thickness * 1e-3))
        free = PERMITTIVITY * VACUUM * math.pi * (D.disc_diameter * 0.5e-3) ** 2 / thickness * 1e3
        high_pass = nearest(finger.piezo_time_constant / free)
        divider = nearest(values["R13"] / (wanted / s.all - 1))
        gain = 1 + values["R13"] / divider
        cells = (
            f"{thickness:g} mm", f"{1e9 * free:.1f} nF", f"{s.all:.3f} V/N",
            f"{high_pass / 1e3:g} kΩ", f"{divider / 1e3:g} kΩ", f"{gain:.1f}",
            f"{gain * s.all:.2f} V/N",
        )  # fmt: skip
        is_drawn = thickness == D.disc_thickness
        rows.append(tuple(f"**{cell}**" if is_drawn else cell for cell in cells))
    return markdown_table(
        "thickness | capacitance | disc | R10, R20 | R14, R24 | gain | at the converter", rows
    )
