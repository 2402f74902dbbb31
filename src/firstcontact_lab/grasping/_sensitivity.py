"""Sensitivity of the gain from stiffness to estimated, not measured, properties of objects."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from firstcontact.twin import HouseholdNumbers, Quantity, household_named
from firstcontact_lab.grasping._household_numbers import (
    Tables,
    baseline,
    candidate,
    fewer,
    judged,
    resample_weights,
)
from firstcontact_lab.grasping._table import Table, Values
from firstcontact_lab.grasping.results import Between

#: Factors by which the estimated limits, masses and friction coefficients are multiplied.
LIMITS, MASSES, FRICTIONS = (0.7, 1.4), (0.8, 1.25), (0.8, 1.25)
#: Number of draws with random factors on the limits, and standard deviation of these factors.
DRAWS, SPREAD = 8, 0.3


def sensitivity(tables: Tables) -> dict[str, Between]:
    """Return the gain from stiffness for each change of the objects' estimated properties."""
    gain_by_case = {}
    names = sorted(set(tables.judged.kinds) | set(tables.tuning.kinds))
    for title, of, factors in (
        ("limits", _limit, LIMITS), ("masses", _mass, MASSES), ("frictions", _friction, FRICTIONS)
    ):  # fmt: skip
        for factor in factors:
            same = dict.fromkeys(names, factor)
            gain_by_case[f"estimated {title} × {factor:g}"] = _gain(tables, of, same.__getitem__)
    rng = np.random.default_rng([tables.seed, 7])
    gains = []
    for _ in range(DRAWS):
        by_kind = dict(zip(names, np.exp(SPREAD * rng.standard_normal(len(names))), strict=True))
        gains.append(_gain(tables, _limit, by_kind.__getitem__, False).value)
    gain_by_case[f"each estimated limit off by {100 * SPREAD:.0f} % by chance, {DRAWS} draws"] = (
        Between(value=float(np.mean(gains)), low=min(gains), high=max(gains))
    )
    return gain_by_case


def _gain(
    tables: Tables,
    of: Callable[[HouseholdNumbers], Quantity | None],
    factor: Callable[[str], float],
    intervals: bool = True,
) -> Between:
    other = replace(
        tables,
        tuning=_changed(tables.tuning, of, factor),
        judged=_changed(tables.judged, of, factor),
    )
    weights = resample_weights(other.judged, other.seed) if intervals else None
    return fewer(judged(other, candidate()), judged(other, baseline()), weights)


def _changed(
    table: Table,
    of: Callable[[HouseholdNumbers], Quantity | None],
    factor: Callable[[str], float],
) -> Table:
    factors: Values = np.ones(len(table.picks))
    for place, pick in enumerate(table.picks):
        quantity = of(household_named(pick.kind).numbers)
        if quantity is not None and quantity.estimated:
            factors[place] = factor(pick.kind)
    if of is _limit:
        return table.otherwise(limit=table.limit * factors)
    return table.otherwise(needed=table.needed * (factors if of is _mass else 1 / factors))


def _limit(numbers: HouseholdNumbers) -> Quantity | None:
    return numbers.limit


def _mass(numbers: HouseholdNumbers) -> Quantity:
    return numbers.mass


def _friction(numbers: HouseholdNumbers) -> Quantity:
    return numbers.friction
