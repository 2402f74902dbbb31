"""Tuning of grasp policies: choice of settings by drops and damage in simulated closings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Estimate
from firstcontact.grasp import Policy
from firstcontact_lab.grasping.picks import household_policy
from firstcontact_lab.grasping.results import ChosenSettings
from firstcontact_lab.grasping.table import ClosingTable, Outcomes, ReflexIndices, Values

#: Words for each family of similar objects: an object whose name has one of them belongs to it. An
#: object without such a word is a family by itself.
FAMILIES = (
    ("raspberry", "blueberry", "strawberry"),
    ("silken tofu", "bread roll"),
    ("peach", "tomato", "banana"),
    ("avocado",),
    ("paper cup", "mug", "wine glass"),
    ("sponge", "foam brick"),
    ("cloth", "stuffed toy"),
    ("orange", "apple"),
    ("quail egg", "hen egg"),
    ("potato crisp", "cracker"),
    ("soup can", "mustard bottle", "sugar box"),
    ("hammer", "wrench", "screwdriver"),
    ("wood block", "Rubik's cube"),
)
#: Scales: factors by which all forces of a policy are multiplied, smallest first.
SCALES = np.exp(np.linspace(np.log(0.25), np.log(4.0), 41))
#: Index of scale 1, which leaves the tuned forces as they are.
TUNED = int(np.argmin(np.abs(SCALES - 1.0)))
DAMAGE = 0.10
#: Shares of damaged picks. Settings are chosen by their mean drops at these shares. The drops at a
#: single share would be too random.
AROUND = (0.07, 0.10, 0.13)
#: Relative scatter of needed and damaging force between the specimens that a pick for tuning
#: represents. Household specimens scatter as much. With this scatter settings do not depend on
#: single specimens.
SCATTER = 0.2

Settings = Mapping[str, float]
PickEstimates = Sequence[Estimate | None]


def family_of(kind: str) -> str:
    """Return the family of an object, or the name of the object if it belongs to no family."""
    for words in FAMILIES:
        if any(word in kind for word in words):
            return " and ".join(words)
    return kind


def assign_folds(kinds: Sequence[str], count: int) -> dict[str, int]:
    """Return the fold of each object, as a dictionary from the object's name to an index.

    Objects of one family get the same fold.
    """
    families = list(dict.fromkeys(family_of(kind) for kind in kinds))
    return {str(kind): families.index(family_of(kind)) % count for kind in kinds}


@dataclass(frozen=True, slots=True, eq=False)
class Front:
    """Shares of dropped and of damaged picks of a policy, for each factor on the grip forces.

    The shape is (factors,) or (factors, resamples).
    """

    dropped: Values
    damaged: Values

    def drop_share(self, damage: float | Values = DAMAGE) -> Values:
        """Return the share of dropped picks at the factor that damages the share ``damage``."""
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


def find_scale(front: Front) -> float:
    """Return the largest factor on forces that damages at most the share ``DAMAGE`` of picks."""
    within = np.flatnonzero(np.maximum.accumulate(front.damaged) <= DAMAGE)
    return float(SCALES[within[-1]] if within.size else SCALES[0])


def compute_front(outcomes: Outcomes, weights: Values | None = None) -> Front:
    count = np.ones(outcomes.dropped.shape[1]) if weights is None else weights
    total = count.sum(axis=0)
    return Front(outcomes.dropped @ count / total, outcomes.damaged @ count / total)


def bootstrap_weights(
    kinds: NDArray[np.str_],
    hands: NDArray[np.intp],
    groups: NDArray[np.str_],
    count: int,
    seed: int,
) -> Values:
    """Return the weight of each pick in ``count`` bootstrap resamples, shape (picks, ``count``).

    Each resample draws objects and hands at random, with replacement. Objects are drawn within
    their group. ``kinds``, ``hands`` and ``groups`` have one entry per pick.
    """
    rng = np.random.default_rng(seed)
    weights = np.ones((len(kinds), count))
    for of, within in ((kinds, groups), (hands, np.full(len(kinds), ""))):
        for group in np.unique(within):
            members = within == group
            values, place = np.unique(of[members], return_inverse=True)
            drawn = rng.integers(len(values), size=(count, len(values)))
            times = np.stack([np.bincount(d, minlength=len(values)) for d in drawn], axis=1)
            weights[members] *= times[place]
    return weights


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    settings: Settings
    outcomes: Outcomes


def policy_settings(
    kind: type[Policy], budget: int, few: bool, seed: int
) -> list[dict[str, float]]:
    """Return the combinations of settings to try for a policy.

    If there are more than ``budget`` combinations, return ``budget`` random ones. With ``few``,
    each setting has only a few values.
    """
    values = [t.few if few else t.tried for t in kind.tunables.values()]
    sizes = [len(v) for v in values]
    total = int(np.prod(sizes))
    chosen: Iterable[tuple[float, ...]] = product(*values)
    if total > budget:
        places = np.random.default_rng(seed).choice(total, budget, replace=False)
        indices = (np.unravel_index(place, sizes) for place in places)
        chosen = (tuple(v[i] for v, i in zip(values, at, strict=True)) for at in indices)
    return [dict(zip(kind.tunables, one, strict=True)) for one in chosen]


def policy_forces(
    kind: type[Policy], settings: Settings, table: ClosingTable, estimates: PickEstimates
) -> Values:
    """Return the grip force that a policy chooses for each pick, N, shape (picks,)."""
    forces = np.empty(len(table.picks))
    for place, (pick, estimate) in enumerate(zip(table.picks, estimates, strict=True)):
        policy = household_policy(kind, pick.kind, settings)
        policy.begin()
        if estimate is not None:
            policy.estimated(estimate)
        forces[place] = policy.target_force()
    return forces


def approach_speed_index(table: ClosingTable, settings: Settings) -> int:
    return table.how.speeds.index(settings["approach"])


def policy_outcomes(
    kind: type[Policy],
    settings: Settings,
    table: ClosingTable,
    estimates: Sequence[PickEstimates],
    reflex: tuple[int, int] | None = None,
    scatter: float = 0.0,
) -> Outcomes:
    """Return the drops and damage of a policy for each factor of ``SCALES`` on its forces.

    The arrays have the shape (factors, picks). ``estimates`` has one list per approach speed.
    ``reflex`` is (lift, latency): indices into ``LIFTS`` and ``DETECTION``. ``scatter`` is the
    relative standard deviation of the forces.
    """
    speed = approach_speed_index(table, settings)
    forces = policy_forces(kind, settings, table, estimates[speed]) * settings.get("scale", 1.0)
    acting = None
    if reflex is not None and kind.has_reflex():
        acting = ReflexIndices(*reflex, table.how.boosts.index(settings["boost"]))
    return table.outcomes(speed, SCALES[:, None] * forces, acting, scatter)


def choose_settings(tried: Sequence[Candidate], selected: NDArray[np.bool_]) -> ChosenSettings:
    """Return the settings that drop the fewest ``selected`` picks at about 10 % damage."""
    weights = selected.astype(np.float64)
    fronts = [compute_front(c.outcomes, weights) for c in tried]
    worth = [np.mean([f.drop_share(d) for d in AROUND]) for f in fronts]
    best = int(np.argmin(worth))
    chosen = fronts[best]
    scale = find_scale(chosen)
    damage = float(chosen.damaged[int(np.argmin(np.abs(SCALES - scale)))])
    settings = {**tried[best].settings, "scale": scale}
    return ChosenSettings(
        left_out=[],
        settings=settings,
        tried=len(tried),
        drops=float(chosen.drop_share()),
        damage=damage,
    )
