"""Quantities that labels state and models predict, such as Shore A: units, scales and texts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import exp
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.physics import gent_modulus, gent_shore_a

#: Largest magnitude of the logarithm of a prediction, as in the chain.
LOGARITHM_MOST = 50.0
#: Values of Shore A at which Gent's formula is used. Close to 0 and 100 it does not hold.
GENT_HOLDS = (5.0, 90.0)


@dataclass(frozen=True, slots=True)
class Quantity:
    """Quantity that a label states and a model predicts.

    Models learn a logarithmic quantity as natural logarithms. Its errors are factors.

    Parameters
    ----------
    name
        Name of the label, such as "stiffness_n_per_mm".
    title, unit
        Name of the quantity in texts and figures, and unit after a number.
    least, most
        Smallest and largest value of a label.
    is_logarithmic
        True for a positive quantity whose values differ by factors.
    is_clipped
        True if prediction intervals are cut at ``least`` and ``most``.
    units
        Factors that convert other units to ``unit``, by the unit's name in lower case. A name with
        capital letters is looked up first as it is. The factor 0 refuses a unit: mPa is not MPa.

    Examples
    --------
    >>> from firstcontact.core.quantity import SHORE_A, STIFFNESS
    >>> STIFFNESS.words(15.04, 12.0, 18.0), STIFFNESS.error_words(0.18)
    ('15 N/mm (12 to 18)', 'x1.20')
    >>> SHORE_A.words(29.0, 20.0, 40.0), SHORE_A.error_words(2.0)
    ('29.0 Shore A (20 to 40)', '2.00 Shore A')
    """

    name: str
    title: str
    unit: str
    least: float
    most: float
    is_logarithmic: bool = False
    is_clipped: bool = True
    units: Mapping[str, float] = field(default_factory=dict, hash=False, compare=False, repr=False)

    @property
    def axis(self) -> str:
        """Label of a figure's axis for this quantity, such as "stiffness (N/mm)"."""
        return self.title if self.title == self.unit else f"{self.title} ({self.unit})"

    @property
    def error_axis(self) -> str:
        """Unit on a figure's axis for errors: "Shore A", or "ln of N/mm" if logarithmic."""
        return f"ln of {self.unit}" if self.is_logarithmic else self.unit

    @property
    def limits(self) -> tuple[float, float] | None:
        """Scaled ``least`` and ``most``, to which intervals are clipped; None if not clipped."""
        if not self.is_clipped:
            return None
        low, high = self.scaled(np.array([self.least, self.most]))
        return float(low), float(high)

    def scaled(self, values: NDArray[Any]) -> NDArray[np.float64]:
        """Convert values to the scale on which models learn them.

        These are natural logarithms for a logarithmic quantity, else the values themselves.
        """
        out: NDArray[np.float64] = np.asarray(values, np.float64)
        if not self.is_logarithmic:
            return out
        with np.errstate(invalid="ignore", divide="ignore"):
            logs: NDArray[np.float64] = np.log(out)
        return logs

    def restored(self, scaled: NDArray[Any]) -> NDArray[np.float64]:
        """Convert scaled values back to the quantity's unit. The inverse of :meth:`scaled`."""
        out: NDArray[np.float64] = np.asarray(scaled, np.float64)
        return np.exp(np.clip(out, -LOGARITHM_MOST, LOGARITHM_MOST)) if self.is_logarithmic else out

    def words(self, value: float, low: float = np.nan, high: float = np.nan) -> str:
        """Return a text with a value, its unit, and the interval if ``high`` is above ``low``."""
        if self.is_logarithmic:
            ends = f" ({_figures(low)} to {_figures(high)})" if high > low else ""
            return f"{_figures(value)} {self.unit}{ends}"
        ends = f" ({low:.0f} to {high:.0f})" if high > low else ""
        return f"{value:.1f} {self.unit}{ends}"

    def label_words(self, value: float) -> str:
        """Return a text with the value of a label and its unit, such as "40 Shore A"."""
        return f"{value:g} {self.unit}" if self.is_clipped else f"{self.title} {value:g}"

    def error_words(self, error: float) -> str:
        """Return an ``error``, on the scale of :meth:`scaled`, as "2.00 Shore A" or "x1.20"."""
        return f"x{exp(error):.2f}" if self.is_logarithmic else f"{error:.2f} {self.unit}"

    def width_words(self, width: float) -> str:
        """Return an interval's width on the scale of :meth:`scaled`: "2.0 Shore A" or "x1.20"."""
        return self.error_words(width) if self.is_logarithmic else f"{width:.1f} {self.unit}"


def _figures(value: float) -> str:
    """Return a number as text: three significant figures, or a whole number from 1000 on."""
    return f"{value:.3g}" if abs(value) < 999.5 else f"{value:.0f}"


SHORE_A = Quantity("shore_a", "Shore A", "Shore A", 0.0, 100.0, units={"shore a": 1.0})
MODULUS = Quantity(
    "modulus_mpa",
    "Young's modulus",
    "MPa",
    1e-4,
    1e6,
    True,
    units={"mPa": 0, "mpa": 1.0, "n/mm2": 1.0, "n/mm^2": 1.0, "kpa": 1e-3, "gpa": 1e3, "pa": 1e-6},
)
STIFFNESS = Quantity(
    "stiffness_n_per_mm",
    "stiffness",
    "N/mm",
    1e-4,
    1e6,
    True,
    units={"n/mm": 1.0, "kn/m": 1.0, "n/m": 1e-3, "kn/mm": 1e3, "n/um": 1e3},
)
RANK = Quantity("hardness_rank", "hardness rank", "ranks", -1000.0, 1000.0, is_clipped=False)

#: Quantities by the names of their labels. The first one that a dataset has is predicted.
QUANTITIES: Mapping[str, Quantity] = {q.name: q for q in (SHORE_A, MODULUS, STIFFNESS, RANK)}
#: Quantities of which a dataset has at most one.
PHYSICAL = (SHORE_A, MODULUS, STIFFNESS)


def shore_a_of_modulus(modulus_mpa: float | None) -> float | None:
    """Convert Young's modulus, MPa, to Shore A by Gent's formula; None outside 5 to 90 Shore A."""
    if modulus_mpa is None:
        return None
    shore_a = gent_shore_a(1e6 * modulus_mpa)
    return shore_a if GENT_HOLDS[0] <= shore_a <= GENT_HOLDS[1] else None


def modulus_of_shore_a(shore_a: float) -> float | None:
    """Convert Shore A to Young's modulus, MPa, by Gent's formula; None outside 5 to 90 Shore A."""
    return 1e-6 * gent_modulus(shore_a) if GENT_HOLDS[0] <= shore_a <= GENT_HOLDS[1] else None
