"""Fit of a finger's force curve to known weights.

A taxel is a piece of Velostat, a sheet whose electrical conductance rises with the force on it. The
conductance is ``leak + gain * force ** exponent``, where the leak is that without a load. The sheet
and a resistor form a voltage divider, and the device measures the voltage over the resistor.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from firstcontact.core import Finger, ForceCurve, InputError
from firstcontact.core.calibration import DIVIDER_OHM
from firstcontact.core.layout import ADC_VOLTS, finger_words
from firstcontact.core.text import parse_float
from firstcontact.recording.table import read_rows

#: Fewest different weights for a curve of three parameters.
LEAST = 4
#: Heaviest weight, N.
HEAVIEST = 1000.0
COLUMNS = ("finger", "newtons", "volts")


@dataclass(frozen=True, slots=True)
class Weighing:
    """Known force (N) on one taxel, and the voltage (V) over the divider's resistor."""

    finger: Finger
    newtons: float
    volts: float


def read_weights(path: Path) -> tuple[Weighing, ...]:
    """Read a CSV with the columns finger (index or thumb), newtons and volts."""
    weighings = []
    for line, row in read_rows(path, COLUMNS):
        try:
            finger = Finger[row["finger"].upper()]
            newtons, volts = parse_float(row["newtons"]), parse_float(row["volts"])
        except (KeyError, ValueError) as error:
            raise InputError(
                f"{path}, line {line}: give the finger (index or thumb), then newtons and volts "
                "as numbers"
            ) from error
        weighings.append(Weighing(finger, newtons, volts))
    return tuple(weighings)


def fit_force(weighings: Sequence[Weighing], resistor: float = DIVIDER_OHM) -> ForceCurve:
    """Fit the force curve of one finger's Velostat sheet: leak without load, gain and exponent."""
    finger = weighings[0].finger if weighings else Finger.INDEX
    subject = f"the weights of the {finger_words(finger)}"
    points = sorted(weighings, key=lambda w: w.newtons)
    force = np.array([w.newtons for w in points])
    volts = np.array([w.volts for w in points])
    if len({w.newtons for w in points}) < LEAST:
        raise InputError(
            f"{subject} have {len({w.newtons for w in points})} different values, but the "
            f"curve needs {LEAST}: add weights"
        )
    if not (force >= 0).all() or not (force <= HEAVIEST).all():
        raise InputError(f"{subject} must be forces in newtons from 0 to {HEAVIEST:g}")
    if not ((volts > 0) & (volts < ADC_VOLTS)).all():
        raise InputError(
            f"the volts of {subject} must lie between 0 and {ADC_VOLTS:g}: check the wiring"
        )
    levels = [(f, volts[force == f].mean()) for f in np.unique(force)]
    for (light, low), (heavy, high) in pairwise(levels):
        if high <= low:
            raise InputError(
                f"{subject} must give a voltage that rises with the force, but {heavy:g} N gives "
                f"{high:.3f} V and {light:g} N gives {low:.3f} V: check the order of the weights"
            )
    curve = _fit(finger, force, volts, resistor)
    rms = float(np.sqrt(np.mean((curve.newtons(volts) - force) ** 2)))
    return replace(curve, rms=rms)


def _fit(
    finger: Finger, force: NDArray[np.float64], volts: NDArray[np.float64], resistor: float
) -> ForceCurve:
    ratio = volts / ADC_VOLTS
    conductance = ratio / (1 - ratio) / resistor
    worth = (1 - ratio) ** 2  # dV/dg, but for a constant
    unit = float(conductance.max())
    strongest = float(force.max())

    def residuals(p: NDArray[np.float64]) -> NDArray[np.float64]:
        model = p[0] + np.exp(p[1]) * (force / strongest) ** p[2]
        return np.asarray((model - conductance / unit) * worth)

    low = float(conductance.min()) / unit
    start = [0.5 * low, math.log(max(1 - 0.5 * low, 1e-3)), 1.0]
    bounds = ([0.0, -10.0, 0.1], [1.0, 3.0, 4.0])
    best = least_squares(residuals, start, bounds=bounds, xtol=1e-12, ftol=1e-12, gtol=1e-12)
    leak, log_gain, exponent = (float(x) for x in best.x)
    gain = math.exp(log_gain) * unit / strongest**exponent
    return ForceCurve(finger, leak * unit, gain, exponent, 0.0, resistor)
