"""Closing speeds that a hand measured, weighted by their precision."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.models._spec import Values

#: Smallest and largest value of a spread or an error of ln(speed). No rig and no measurement is
#: more exact than LEAST, and no speeds differ by more than MOST.
LEAST, MOST = 0.01, 10.0
#: Largest variance of the measurements' errors, as a share of the variance of the rig's speeds.
#: Noisier measurements are not used. Higher limits cost more on rigs with one closing speed than
#: they gained elsewhere.
MOST_NOISE = 0.5
#: Spread of ln(speed) that is assumed for a rig with fewer than FEWEST pinches, and for old files.
ASSUMED, FEWEST = 0.2, 4
#: Relative error above which a measurement is ignored for the rig.
USELESS = 0.5
#: Distance from the quartiles, in interquartile ranges, above which a value counts as an outlier:
#: 3.4 standard deviations of a normal variable.
FENCE = 2.0


@dataclass(frozen=True, slots=True)
class RigSpeeds:
    """Closing speeds of a rig, from its hand's measurements and its motor's pitch."""

    usual: float
    spread: float = ASSUMED
    heard_error: float = np.inf

    @classmethod
    def fit(
        cls, speeds: Values, errors: Values, heard: Values, believed: NDArray[np.bool_]
    ) -> Self | None:
        """Return the speeds of a rig from its own pinches."""
        is_measured = np.isfinite(speeds) & (_bounded(errors) <= USELESS)
        if not is_measured.any():
            return None
        usual = float(np.median(speeds[is_measured]))
        log, noise = _log_ratio(speeds, usual), _bounded(errors) ** 2
        both = is_measured & believed
        has_spread, has_heard = is_measured.sum() >= FEWEST, both.sum() >= FEWEST
        spread = _spread(log[is_measured], noise[is_measured]) if has_spread else ASSUMED
        if np.median(noise[is_measured]) > MOST_NOISE * spread**2:
            return None
        heard_error = _spread((heard - log)[both], noise[both]) if has_heard else np.inf
        return cls(usual, spread, heard_error)


def _log_ratio(speeds: Values, usual: float) -> Values:
    out: Values = np.log(np.maximum(speeds, 1e-6) / usual)
    return out


def _bounded(errors: Values) -> Values:
    """Return relative errors within bounds. NaN counts as exact, infinity as no measurement."""
    return np.maximum(np.where(np.isnan(errors), 0.0, errors), LEAST)


def _spread(values: Values, noise: Values) -> float:
    """Return the standard deviation of values without outliers, corrected for their noise."""
    low, high = np.quantile(values, [0.25, 0.75])
    reach = FENCE * max(high - low, LEAST)
    usual = values[(values >= low - reach) & (values <= high + reach)]
    return max(float(np.sqrt(max(np.var(usual, ddof=1) - np.median(noise), 0.0))), LEAST)
