"""Features of a contact's first milliseconds that do not depend on the gain.

All amplitudes are relative to the contact's peak or to the rig's level: its typical peak, see
:class:`firstcontact.models._rig.Rig`. The valid samples of a contact are those that its prediction
may use: they end before the second contact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.models._spec import Values

#: Smallest amplitude, as a share of the rig's level. Smaller amplitudes count as this one, so that
#: a logarithm exists.
LEAST = 1e-4
NAMES = (
    "peak",
    "steepest rise",
    "time to peak",
    "time to a tenth",
    "time to a half",
    "width at half",
    "roughness",
    "undershoot",
    "time to undershoot",
    "power",
    "centre of energy",
    "length",
    "last value",
    "last slope",
)


def masked(signals: NDArray[np.floating], valid: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return the signals (n, samples) with zeros from sample ``valid`` on."""
    samples = np.arange(signals.shape[1])
    return np.where(samples < valid[:, None], signals, 0.0)


def features(v: NDArray[np.float64], valid: NDArray[np.intp], level: Values) -> NDArray[np.float64]:
    """Return features of each signal, from its valid samples only.

    Parameters
    ----------
    v
        Signals from the contact on, masked, positive in the direction of the first swing, V,
        shape (n, samples).
    valid
        Number of valid samples of each signal, at least 2, shape (n,).
    level
        Level of each contact's rig, V, shape (n,).

    Returns
    -------
    ndarray
        Features with magnitudes around 1, shape (n, len(NAMES)).
    """
    n, samples = v.shape
    rows = np.arange(n)
    t = np.arange(samples)
    scale = samples / 74.0  # times below are in samples of a window of 74
    floor = LEAST * level
    peak = np.maximum(v.max(axis=1), floor)
    at = v.argmax(axis=1)
    steps = v[:, 1:] - v[:, :-1]
    steps[t[1:] >= valid[:, None]] = 0.0
    rise = np.maximum(steps.max(axis=1), floor)
    rising = t <= at[:, None]
    relative = v / peak[:, None]
    tenth = ((relative < 0.1) & rising).sum(axis=1)
    half = ((relative < 0.5) & rising).sum(axis=1)
    width = (relative > 0.5).sum(axis=1)
    falling = (t > at[:, None]) & (t < valid[:, None])
    fall_times = np.where(falling, relative, np.inf)
    low_at = fall_times.argmin(axis=1)
    low = fall_times[rows, low_at]
    none = ~np.isfinite(low)
    low[none], low_at[none] = 1.0, at[none]
    energy = v * v
    total = energy.sum(axis=1) + LEAST * LEAST * level * level
    rms = np.sqrt(total / valid)
    centre = energy @ t / total
    rough = (steps * steps).sum(axis=1) / total
    last = relative[rows, valid - 1]
    earlier = relative[rows, np.maximum(valid - 4, 0)]
    columns = (
        np.log(peak / level),
        np.log(rise / level),
        at / (20 * scale) - 1,
        tenth / (10 * scale) - 0.5,
        half / (10 * scale) - 0.5,
        width / (20 * scale) - 0.5,
        np.log(rough + 1e-4) + 2,
        low,
        low_at / (40 * scale) - 1,
        np.log(rms / level),
        centre / (20 * scale) - 1,
        valid / (37 * scale) - 1,
        last,
        last - earlier,
    )
    return np.array(columns).T


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """Signals of contacts and the features of their valid samples, computed once.

    Parameters
    ----------
    v
        Signals after the contact, masked, positive in the direction of the first swing, V, shape
        (n, samples).
    is_valid
        Mask of the valid samples, shape (n, samples).
    features
        Result of :func:`features`.
    level
        Level of each contact's rig, V, shape (n,).
    """

    v: NDArray[np.float64]
    is_valid: NDArray[np.bool_]
    features: NDArray[np.float64]
    level: Values

    @classmethod
    def measure(
        cls, signals: NDArray[np.floating], valid: NDArray[np.intp], level: Values, sign: Values
    ) -> Shape:
        """Return the shape of signals (n, samples) that begin at their contacts."""
        is_valid = np.arange(signals.shape[1]) < valid[:, None]
        v = np.where(is_valid, sign[:, None] * signals, 0.0)
        return cls(v, is_valid, features(v, valid, level), level)
