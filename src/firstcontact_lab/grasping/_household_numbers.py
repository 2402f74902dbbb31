"""Results of the household part from tables of closings: fronts, drops and control experiments."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from firstcontact.grasp import POLICIES, Part, Policy, Task
from firstcontact.testing import make_estimate
from firstcontact.twin import household_named
from firstcontact_lab.grasping._branches import DETECTION, LIFTS
from firstcontact_lab.grasping._families import folds
from firstcontact_lab.grasping._front import SCALES, Front, find_scale, front, resampled
from firstcontact_lab.grasping._table import Outcomes, Reflexed, Table
from firstcontact_lab.grasping._tuning import (
    SCATTER,
    Candidate,
    Chosen,
    Settings,
    Told,
    candidates,
    choose,
    policy_forces,
    policy_settings,
    speed_place,
    swept,
)
from firstcontact_lab.grasping.results import Between

#: Number of resamples for an interval.
RESAMPLES = 1000
#: Half width of a normal's 90 % interval, in standard deviations.
NORMAL = 1.645


@dataclass(frozen=True, slots=True)
class Tables:
    """Tables for tuning and for judging: same objects, but different hands and specimens."""

    tuning: Table
    judged: Table
    folds: int
    budget: int
    few: bool
    seed: int


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """Outcomes of a policy on objects and hands on which its settings were not tuned.

    Parameters
    ----------
    outcomes
        Outcomes by scale (the factor on the tuned forces, smallest first), and by pick.
    chosen
        Chosen settings, one for each fold of objects.
    """

    outcomes: Outcomes
    chosen: tuple[Chosen, ...]

    @property
    def front(self) -> Front:
        """Shares of dropped and of damaged picks at each scale, over all picks."""
        return front(self.outcomes)


def household_policies() -> dict[str, type[Policy]]:
    """Return the policies for household objects by name, in the order of the registry."""
    return {n: p for n, p in POLICIES.items() if p.task is Task.HOUSEHOLD}


def baseline(reflex: bool = False) -> type[Policy]:
    """Return the policy that uses no stiffness, with or without a slip reflex."""
    return next(
        p
        for p in household_policies().values()
        if p.part is Part.BASELINE and p.has_reflex() is reflex
    )


def candidate(reflex: bool = False) -> type[Policy]:
    """Return the policy that acts on the estimate, with or without a slip reflex."""
    return next(
        p
        for p in household_policies().values()
        if p.part is Part.CANDIDATE and p.has_reflex() is reflex
    )


def labelled(table: Table, rmse: float, seed: int) -> list[Told]:
    """Return noisy labels of all picks in place of estimates. Each speed gets the same list."""
    rng = np.random.default_rng([seed, round(1e3 * rmse)])
    noisy = table.shore_a + rmse * rng.standard_normal(len(table.picks))
    half = NORMAL * rmse
    estimates = [make_estimate(float(s), float(s) - half, float(s) + half) for s in noisy]
    return [estimates for _ in table.how.speeds]


def tried_on(
    tables: Tables,
    kind: type[Policy],
    estimates: Sequence[Told],
    reflex: tuple[int, int] | None = None,
) -> list[Candidate]:
    """Return the settings to try for a policy, with their outcomes in the table for tuning."""
    settings = policy_settings(kind, tables.budget, tables.few, tables.seed)
    return candidates(kind, settings, tables.tuning, estimates, reflex)


def judged(
    tables: Tables,
    kind: type[Policy],
    estimates: tuple[Sequence[Told], Sequence[Told]] | None = None,
    reflex: tuple[int, int] | None = None,
) -> Judged:
    """Judge a policy on each fold of objects, with settings tuned on all other folds."""
    tuning, judging = (
        (tables.tuning.estimates, tables.judged.estimates) if estimates is None else estimates
    )
    tried = tried_on(tables, kind, tuning, reflex)

    @cache
    def outcomes(settings: tuple[tuple[str, float], ...]) -> Outcomes:
        outcome: Settings = dict(settings)
        speed = tables.judged.how.speeds.index(outcome["approach"])
        return swept(kind, outcome, tables.judged, judging[speed], reflex)

    return _by_fold(tables, tried, lambda chosen: outcomes(tuple(chosen.settings.items())))


def _by_fold(
    tables: Tables, tried: Sequence[Candidate], outcomes: Callable[[Chosen], Outcomes]
) -> Judged:
    fold_of = folds(sorted(set(tables.tuning.kinds) | set(tables.judged.kinds)), tables.folds)
    learn = np.array([fold_of[k] for k in tables.tuning.kinds])
    ask = np.array([fold_of[k] for k in tables.judged.kinds])
    dropped, damaged = np.zeros((2, len(SCALES), len(ask)))
    chosen = []
    for fold in range(tables.folds):
        chosen.append(choose(tried, learn != fold))
        outcome, selected = outcomes(chosen[-1]), ask == fold
        dropped[:, selected], damaged[:, selected] = (
            outcome.dropped[:, selected],
            outcome.damaged[:, selected],
        )
    return Judged(Outcomes(dropped, damaged), tuple(chosen))


def ceiling(table: Table) -> Front:
    """Return the front of the best choice for each pick: approach speed, force and slip reflex."""
    forces = np.exp(np.linspace(np.log(table.how.forces[0]), np.log(table.how.forces[-1]), 60))
    grid = np.repeat(forces[:, None], len(table.picks), axis=1)
    reflexes = product(range(len(LIFTS)), range(len(DETECTION)), range(len(table.how.boosts)))
    acting = [None, *(Reflexed(*places) for places in reflexes)]
    outcome_list = [
        table.outcomes(v, grid, r) for v in range(len(table.how.speeds)) for r in acting
    ]
    dropped = np.concatenate([f.dropped for f in outcome_list])
    damaged = np.concatenate([f.damaged for f in outcome_list])
    picks = np.arange(len(table.picks))
    points = []
    for price in (100.0, 0.01):
        best = np.argmin(dropped + price * damaged, axis=0)
        points.append((dropped[best, picks].mean(), damaged[best, picks].mean()))
    both = np.array(points)
    return Front(both[:, 0], both[:, 1])


def resample_weights(table: Table, seed: int) -> NDArray[np.float64]:
    """Return bootstrap weights of the picks: each resample draws kinds and hands."""
    groups = np.array([household_named(pick.kind).group for pick in table.picks])
    return resampled(table.kinds, table.hands, groups, RESAMPLES, seed)


def between(value: float, drawn: NDArray[np.float64]) -> Between:
    """Return a number with its interval: the middle 95 % of the values in ``drawn``."""
    low, high = np.nanpercentile(drawn, [2.5, 97.5])
    return Between(value=value, low=float(low), high=float(high))


def drops(outcome_list: Judged, weights: NDArray[np.float64]) -> Between:
    """Return the share of dropped picks at 10 % damage, with its bootstrap interval."""
    return between(
        float(outcome_list.front.drop_share()), front(outcome_list.outcomes, weights).drop_share()
    )


def less(dropped: NDArray[np.float64], theirs: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return 1 - ``dropped`` / ``theirs``, the relative reduction in drops, limited to -1 to 1."""
    ratio = np.where(
        theirs > 0, dropped / np.maximum(theirs, 1e-9), np.where(dropped > 0, 2.0, 1.0)
    )
    gain: NDArray[np.float64] = np.clip(1 - ratio, -1.0, 1.0)
    return gain


def fewer(ours: Judged, theirs: Judged, weights: NDArray[np.float64] | None = None) -> Between:
    """Return the relative reduction in drops from policy ``theirs`` to ``ours``, at 10 % damage."""
    value = float(less(ours.front.drop_share(), theirs.front.drop_share()))
    if weights is None:
        return Between(value=value, low=value, high=value)
    mine, baseline_drops = (front(j.outcomes, weights).drop_share() for j in (ours, theirs))
    return between(value, less(mine, baseline_drops))


def fewer_as_bold(ours: Judged, theirs: Judged, weights: NDArray[np.float64]) -> Between:
    """Return the reduction in drops like :func:`fewer`, but do not scale forces in resamples."""
    a, b = (int(np.argmin(np.abs(SCALES - find_scale(j.front)))) for j in (ours, theirs))
    mine, baseline_drops = front(ours.outcomes, weights), front(theirs.outcomes, weights)
    # Over all picks both policies damage a tenth, apart from the steps between scales.
    apart = ours.front.damaged[a] - theirs.front.damaged[b]
    dropped = mine.dropped[a] + mine.damaged[a] - baseline_drops.damaged[b] - apart
    return between(fewer(ours, theirs).value, less(dropped, baseline_drops.dropped[b]))


def conditions() -> dict[str, tuple[int, int]]:
    """Return the indices of lift and of detection latency, by names such as "abrupt, 100 ms"."""
    return {
        f"{lift}, {1e3 * wait:g} ms": (a, b)
        for a, lift in enumerate(LIFTS)
        for b, wait in enumerate(DETECTION)
    }


def permuted(tables: Tables, count: int, mass: bool, damage: bool, seed: int) -> Between:
    """Return the gain from stiffness if objects get the weight or the limit of other objects."""
    names = sorted(set(tables.judged.kinds))
    rng = np.random.default_rng([seed, mass, damage])
    kinds = (baseline(), candidate())
    tried = {k.name: tried_on(tables, k, tables.tuning.estimates) for k in kinds}
    pressed = {k.name: _pressed(tables.tuning, k, tried[k.name]) for k in kinds}
    gains = []
    for _ in range(count):
        by_mass = dict(zip(names, rng.permutation(names), strict=True)) if mass else {}
        by_limit = dict(zip(names, rng.permutation(names), strict=True)) if damage else {}
        other = Tables(
            _given(tables.tuning, by_mass, by_limit), _given(tables.judged, by_mass, by_limit),
            tables.folds, tables.budget, tables.few, tables.seed,
        )  # fmt: skip
        outcome = []
        for kind in kinds:
            again = [
                Candidate(c.settings, other.tuning.judge(peak, hold, SCATTER))
                for c, (peak, hold) in zip(tried[kind.name], pressed[kind.name], strict=True)
            ]
            outcome.append(_by_fold(other, again, _judge(other, kind)))
        theirs, ours = outcome
        gains.append(fewer(ours, theirs).value)
    return between(float(np.mean(gains)), np.array(gains))


def _judge(tables: Tables, kind: type[Policy]) -> Callable[[Chosen], Outcomes]:
    def outcomes(chosen: Chosen) -> Outcomes:
        speed = tables.judged.how.speeds.index(chosen.settings["approach"])
        return swept(kind, chosen.settings, tables.judged, tables.judged.estimates[speed], None)

    return outcomes


def _pressed(
    table: Table, kind: type[Policy], tried: Sequence[Candidate]
) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    outcome_list = []
    for one in tried:
        speed = speed_place(table, one.settings)
        forces = policy_forces(kind, one.settings, table, table.estimates[speed])
        outcome_list.append(table.pressed(speed, SCALES[:, None] * forces))
    return outcome_list


def _given(table: Table, by_mass: Mapping[str, str], by_limit: Mapping[str, str]) -> Table:
    """Return the table with the needed forces and the limits of other kinds of object."""
    place = {(p.kind, p.hand, p.specimen): i for i, p in enumerate(table.picks)}

    def indices(by: Mapping[str, str]) -> NDArray[np.intp]:
        return np.array([place[by.get(p.kind, p.kind), p.hand, p.specimen] for p in table.picks])

    return table.otherwise(table.needed[indices(by_mass)], table.limit[indices(by_limit)])
