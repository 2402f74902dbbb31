"""Force array as a network of resistors: two ways to hold the rows that are not driven.

*Floating*: current also flows from the driven row through other taxels and floating rows, so a
taxel reads the load of its neighbours. *Grounded*: the rows are at fixed voltages, so no column
affects another. The readings of a column then give its conductances in closed form.

    python hardware/taxels.py    # writes the table of decision 0023
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.collect.calibration import Weighing, fit_force
from firstcontact.core.calibration import ForceCurve
from firstcontact.core.layout import ADC_COUNTS, ADC_VOLTS, Finger
from firstcontact.twin.mechanics import VelostatParameters
from firstcontact_lab.report.tables import fill, markdown_table

ROWS, COLUMNS = 3, 2
SHEET = VelostatParameters()
#: Position of each taxel on the board of 20 x 15 mm, mm.
PLACES = np.array(
    [(20 / 3 * (r - 1), 7.5 * (c - 0.5)) for r in range(ROWS) for c in range(COLUMNS)]
)
#: Weights of the calibration, N, and number of readings in the device's mean.
WEIGHTS, READINGS = (0.0, 0.5, 1.0, 2.0, 5.0), 8
PAGE = Path(__file__).resolve().parents[1] / "docs/decisions/0023-rows-at-ground.md"
Array = NDArray[Any]


class Method(StrEnum):
    """Way to hold the rows that are not driven, and to use the readings."""

    FLOATING = "other rows float, each reading used alone"
    GROUNDED = "other rows at ground, each reading used alone"
    SOLVED = "other rows at ground, columns solved"


def conductances(forces: Sequence[float] | Array) -> Array:
    """Return the conductance of each taxel under these forces, N, in S, without a threshold."""
    return SHEET.leak + SHEET.conductance * np.asarray(forces, dtype=float) ** SHEET.exponent


def readings(conductance: Array, method: Method, series: float = SHEET.row) -> Array:
    """Return the voltage of each taxel's column while the taxel's row is driven, V.

    ``series`` is the resistance in each row, ohm.
    """
    g = conductance.reshape(ROWS, COLUMNS)
    volts = np.zeros((ROWS, COLUMNS))
    for driven in range(ROWS):
        held = np.full(ROWS, 0.0 if method is Method.FLOATING else 1 / series)
        held[driven] = 1 / series
        rows = np.diag(held + g.sum(axis=1))
        columns = np.diag(1 / SHEET.resistor + g.sum(axis=0))
        currents = np.zeros(ROWS + COLUMNS)
        currents[driven] = ADC_VOLTS / series
        nodes = np.linalg.solve(np.block([[rows, -g], [-g.T, columns]]), currents)
        volts[driven] = nodes[ROWS:]
    return volts.ravel()


def alone(volts: Array) -> Array:
    """Return the voltage that each taxel would give alone in its column, V.

    The device computes it in the same way.
    """
    others = volts.reshape(ROWS, COLUMNS).sum(axis=0) - volts.reshape(ROWS, COLUMNS)
    return ADC_VOLTS * volts / (ADC_VOLTS - others.ravel())


def sampled(volts: Array, rng: np.random.Generator) -> Array:
    """Return the mean of noisy readings of these voltages by the converter, V."""
    noisy = volts + SHEET.noise * rng.standard_normal((READINGS, volts.size))
    step = ADC_VOLTS / ADC_COUNTS
    return np.clip(np.floor(noisy / step), 0, ADC_COUNTS - 1).mean(axis=0) * step


def measured(forces: Array, method: Method, rng: np.random.Generator) -> Array:
    """Return the voltages of all taxels that the device sends for these forces, N."""
    volts = sampled(readings(conductances(forces), method), rng)
    return alone(volts) if method is Method.SOLVED else volts


def calibrated(method: Method, rng: np.random.Generator) -> ForceCurve:
    """Return the force curve that ``calibrate --weigh`` would fit to weights on the first taxel."""
    weighings = []
    for newtons in WEIGHTS:
        volts = measured(np.array([newtons, 0, 0, 0, 0, 0]), method, rng)
        weighings.append(Weighing(Finger.INDEX, newtons, float(volts[0])))
    return fit_force(weighings, SHEET.resistor)


def errors(method: Method, pinches: int, seed: int) -> tuple[float, float, float]:
    """Return errors of random pinches of 2 to 12 N, after a calibration with weights.

    The first taxel is unloaded, and the force divides at random among the others.

    Returns
    -------
    tuple
        Mean force on the unloaded taxel (N), RMS error of the sum of the forces (share of it), and
        RMS distance of the centre of pressure from the true one (mm).
    """
    rng = np.random.default_rng(seed)
    curve = calibrated(method, rng)
    rows = []
    for _ in range(pinches):
        total = rng.uniform(2, 12)
        forces = np.append(0.0, total * rng.dirichlet(np.full(5, 2.0)))
        felt = curve.newtons(measured(forces, method, rng))
        centre = (felt @ PLACES / felt.sum() - forces @ PLACES / total) if felt.sum() else 0.0
        rows.append((felt[0], (felt.sum() / total - 1) ** 2, np.sum(centre**2)))
    unloaded, total_error, distance = np.mean(rows, axis=0)
    return float(unloaded), float(total_error**0.5), float(distance**0.5)


def table(pinches: int = 2000, seed: int = 1) -> str:
    """Return a Markdown table of the errors of each method."""
    rows = []
    for method in Method:
        unloaded, total, distance = errors(method, pinches, seed)
        rows.append((method, f"{unloaded:.2f} N", f"{100 * total:.1f} %", f"{distance:.2f} mm"))
    head = "method | an unloaded taxel reads | error of the sum, RMS | error of the centre, RMS"
    return markdown_table(head, rows)


def filled(text: str) -> str:
    """Return the page ``text`` with its table replaced."""
    return fill(text, "hardware", {"taxels": table()})


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text("utf-8")), "utf-8")
