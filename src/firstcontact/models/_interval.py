"""Interval around predictions, as a table of half widths."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass

import numpy as np

from firstcontact.models._spec import Values

#: Ends of the Shore A scale.
SHORE_A = (0.0, 100.0)
#: Largest number in an interval, so that predictions with their bounds stay finite.
LARGEST = 1e9


@dataclass(frozen=True, slots=True)
class Interval:
    """Interval around a prediction, whose width depends on the prediction.

    Parameters
    ----------
    level
        Nominal share of intervals that contain the truth, between 0 and 1.
    edges
        Predictions at which the width changes, ascending; one fewer than ``half_widths``.
    half_widths
        Half widths between the edges, in the unit of the prediction.
    limits
        Ends of the scale, to which the bounds are clipped; None for a scale without ends.
    scaled
        True if half widths are multiples of the predicted standard deviation.

    Raises
    ------
    ValueError
        The numbers do not fit together.

    Examples
    --------
    >>> interval = Interval(0.9, edges=(30.0,), half_widths=(2.0, 5.0))
    >>> interval.around(20.0), interval.around(98.0)
    ((18.0, 22.0), (93.0, 100.0))
    """

    level: float
    edges: tuple[float, ...]
    half_widths: tuple[float, ...]
    limits: tuple[float, float] | None = SHORE_A
    scaled: bool = False

    def __post_init__(self) -> None:
        numbers = (self.level, *self.edges, *self.half_widths, *(self.limits or ()))
        if (
            not all(abs(n) <= LARGEST for n in numbers)
            or not 0.0 < self.level < 1.0
            or len(self.half_widths) != len(self.edges) + 1
            or min(self.half_widths) < 0.0
            or list(self.edges) != sorted(self.edges)
            or (self.limits is not None and self.limits[0] >= self.limits[1])
        ):
            raise ValueError(
                "level, edges, half_widths or limits of an interval do not fit together"
            )

    def around(self, value: float, spread: float = 1.0) -> tuple[float, float]:
        """Return the lower and upper bound for a prediction.

        Parameters
        ----------
        value
            Prediction.
        spread
            Predicted standard deviation, if the interval is scaled by it.
        """
        half = self.half_widths[bisect_right(self.edges, value)]
        if self.scaled:
            half *= spread
        low, high = value - half, value + half
        if self.limits is None:
            return low, high
        least, most = self.limits
        return min(max(low, least), most), min(max(high, least), most)

    def around_all(self, values: Values, spreads: Values | None = None) -> tuple[Values, Values]:
        """Return the lower and upper bounds of :meth:`around` for predictions, shape (n,) each."""
        half = np.array(self.half_widths)[np.searchsorted(self.edges, values, side="right")]
        if self.scaled and spreads is not None:
            half = half * spreads
        low, high = values - half, values + half
        if self.limits is None:
            return low, high
        return np.clip(low, *self.limits), np.clip(high, *self.limits)
