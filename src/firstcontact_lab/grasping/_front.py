"""Trade-off between drops and damage, when all forces of a policy are scaled by a factor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact_lab.grasping._table import Outcomes, Values

#: Scales: factors by which all forces of a policy are multiplied, smallest first.
SCALES = np.exp(np.linspace(np.log(0.25), np.log(4.0), 41))
#: Index of scale 1, which leaves the tuned forces as they are.
TUNED = int(np.argmin(np.abs(SCALES - 1.0)))
#: Share of damaged picks at which drops are compared.
DAMAGE = 0.10
#: Shares of damaged picks. Settings are chosen by their mean drops at these shares. The drops at a
#: single share would be too random.
AROUND = (0.07, 0.10, 0.13)


@dataclass(frozen=True, slots=True, eq=False)
class Front:
    """Shares of dropped and of damaged picks, shape (scales,) or (scales, resamples)."""

    dropped: Values
    damaged: Values

    def drop_share(self, damage: float | Values = DAMAGE) -> Values:
        """Return the share of dropped picks at the scale that damages the share ``damage``."""
        dropped, damaged = np.atleast_2d(self.dropped.T), np.atleast_2d(self.damaged.T)
        wanted = np.broadcast_to(damage, len(dropped))
        rows = zip(dropped, damaged, wanted.tolist(), strict=True)
        out = np.array([_drop_share(d, b, w) for d, b, w in rows])
        return out if self.dropped.ndim > 1 else out[0]


def _drop_share(dropped: Values, damaged: Values, damage: float) -> float:
    rising = np.maximum.accumulate(damaged)
    if rising[0] > damage:
        floor = int(np.searchsorted(rising, rising[0], side="right")) - 1
        return float(dropped[floor] + rising[0] - damage)
    last = int(np.searchsorted(rising, damage, side="right")) - 1
    if last >= len(rising) - 1:
        return float(dropped.min())
    part = (damage - rising[last]) / (rising[last + 1] - rising[last])
    return float(dropped[last] + part * (dropped[last + 1] - dropped[last]))


def find_scale(front: Front, damage: float = DAMAGE) -> float:
    """Return the largest scale at which at most the share ``damage`` of the picks is damaged."""
    within = np.flatnonzero(np.maximum.accumulate(front.damaged) <= damage)
    return float(SCALES[within[-1]] if within.size else SCALES[0])


def front(outcomes: Outcomes, weights: NDArray[np.float64] | None = None) -> Front:
    """Return the shares of dropped and of damaged picks at each scale."""
    count = np.ones(outcomes.dropped.shape[1]) if weights is None else weights
    total = count.sum(axis=0)
    return Front(
        outcomes.dropped @ count / total,
        outcomes.damaged @ count / total,
    )


def resampled(
    kinds: NDArray[np.str_],
    hands: NDArray[np.intp],
    groups: NDArray[np.str_],
    count: int,
    seed: int,
) -> NDArray[np.float64]:
    """Return bootstrap weights of picks: objects and hands are drawn with replacement."""
    rng = np.random.default_rng(seed)
    weights = np.ones((len(kinds), count))
    everywhere = np.full(len(kinds), "")
    for of, within in ((kinds, groups), (hands, everywhere)):
        for group in np.unique(within):
            members = within == group
            values, place = np.unique(of[members], return_inverse=True)
            drawn = rng.integers(len(values), size=(count, len(values)))
            times = np.stack([np.bincount(d, minlength=len(values)) for d in drawn], axis=1)
            weights[members] *= times[place]
    return weights
