"""Choice of each policy's settings by outcomes in the table. All policies have one budget."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Estimate
from firstcontact.grasp import FinalForce, Grip, Policy, Truth, make_policy
from firstcontact.twin import household_named
from firstcontact_lab.grasping._front import AROUND, SCALES, Front, find_scale, front
from firstcontact_lab.grasping._table import Outcomes, Reflexed, Table, Values

#: Relative scatter of needed and damaging force between the specimens that a pick for tuning
#: represents. Household specimens scatter as much. With this scatter settings do not depend on
#: single specimens.
SCATTER = 0.2
Settings = Mapping[str, float]
#: Estimate that a policy gets for each pick; None without an estimate.
Told = Sequence[Estimate | None]


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """Settings of a policy, and the outcomes of all picks with these settings, at every scale."""

    settings: Settings
    outcomes: Outcomes


@dataclass(frozen=True, slots=True)
class Chosen:
    """Settings that were chosen for one fold."""

    settings: dict[str, float]
    tried: int
    drops: float
    damage: float


def policy_settings(
    kind: type[Policy], budget: int, few: bool, seed: int
) -> list[dict[str, float]]:
    """Return all settings of a policy; if there are more than ``budget``, a random sample."""
    names = list(kind.tunables)
    values = [t.few if few else t.tried for t in kind.tunables.values()]
    total = int(np.prod([len(v) for v in values]))
    if total <= budget:
        return [dict(zip(names, chosen, strict=True)) for chosen in product(*values)]
    places = np.random.default_rng(seed).choice(total, budget, replace=False)
    sizes = [len(v) for v in values]
    return [
        {n: v[i] for n, v, i in zip(names, values, np.unravel_index(p, sizes), strict=True)}
        for p in places
    ]


def policy_forces(kind: type[Policy], settings: Settings, table: Table, estimates: Told) -> Values:
    """Return the force of a policy for every pick, N, shape (picks,)."""
    forces = np.empty(len(table.picks))
    for place, pick in enumerate(table.picks):
        numbers = household_named(pick.kind).numbers
        truth = Truth(numbers.shore_a.value, numbers.mass.value)
        policy = make_policy(kind, Grip(), truth, settings)
        if not isinstance(policy, FinalForce):
            raise TypeError(
                f"{kind.name} is not a policy for household objects: derive it from FinalForce"
            )
        policy.begin()
        estimate = estimates[place]
        if estimate is not None:
            policy.estimated(estimate)
        forces[place] = policy.target_force()
    return forces


def speed_place(table: Table, settings: Settings) -> int:
    """Return the table's index of the approach speed in the settings."""
    return table.how.speeds.index(settings["approach"])


def swept(
    kind: type[Policy],
    settings: Settings,
    table: Table,
    estimates: Told,
    reflex: tuple[int, int] | None,
    scatter: float = 0.0,
) -> Outcomes:
    """Return the outcomes of a policy, by scale and pick, with these settings."""
    forces = policy_forces(kind, settings, table, estimates) * settings.get("scale", 1.0)
    acting = None
    if reflex is not None and kind.has_reflex():
        acting = Reflexed(*reflex, table.how.boosts.index(settings["boost"]))
    speed = speed_place(table, settings)
    return table.outcomes(speed, SCALES[:, None] * forces, acting, scatter)


def candidates(
    kind: type[Policy],
    tried: Sequence[Settings],
    table: Table,
    estimates: Sequence[Told],
    reflex: tuple[int, int] | None = None,
) -> list[Candidate]:
    """Return a candidate for each of the ``tried`` settings, with its outcomes in the table."""
    return [
        Candidate(s, swept(kind, s, table, estimates[speed_place(table, s)], reflex, SCATTER))
        for s in tried
    ]


def choose(tried: Sequence[Candidate], selected: NDArray[np.bool_]) -> Chosen:
    """Choose the settings with which the fewest selected picks drop, at about 10 % damage."""
    weights = selected.astype(np.float64)
    fronts = [front(c.outcomes, weights) for c in tried]
    worth = [np.mean([f.drop_share(d) for d in AROUND]) for f in fronts]
    best = int(np.argmin(worth))
    chosen = fronts[best]
    scale = find_scale(chosen)
    settings = {**tried[best].settings, "scale": scale}
    return Chosen(settings, len(tried), float(chosen.drop_share()), _damage(chosen, scale))


def _damage(points: Front, scale: float) -> float:
    return float(points.damaged[int(np.argmin(np.abs(SCALES - scale)))])
