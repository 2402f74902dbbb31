"""From tables to what is reported: fronts, drops at a tenth of damage, controls, what is left."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from firstcontact.grasp import POLICIES, Part, Policy, Stiffness, Task
from firstcontact.twin import household_named
from firstcontact_lab.grasping._branches import DETECTION, LIFTS
from firstcontact_lab.grasping._families import folds
from firstcontact_lab.grasping._front import SCALES, Front, front, resampled, scale_at
from firstcontact_lab.grasping._table import Outcomes, Reflexed, Table
from firstcontact_lab.grasping._tuning import (
    SCATTER,
    Candidate,
    Chosen,
    Settings,
    Told,
    candidates,
    choose,
    forces_of,
    settings_of,
    speed_place,
    swept,
)
from firstcontact_lab.grasping.results import Between

#: Resamples of an interval.
RESAMPLES = 1000
#: Half width of a normal's 90 % interval, in standard deviations.
NORMAL = 1.645


@dataclass(frozen=True, slots=True)
class Tables:
    """What is tuned on, and what is judged: other hands and specimens of the same kinds.

    Parameters
    ----------
    tuning, judged
        Tables of the same speeds, forces and boosts.
    folds
        In how many parts families are left out.
    budget
        Settings of each policy.
    few
        Whether few values of each setting are tried.
    seed
        Of settings, noise and intervals.
    """

    tuning: Table
    judged: Table
    folds: int
    budget: int
    few: bool
    seed: int


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """A policy on picks of kinds and hands that it was not tuned on.

    Parameters
    ----------
    outcomes
        By scale, from more to less cautious than tuned, and judged pick.
    chosen
        By fold.
    """

    outcomes: Outcomes
    chosen: tuple[Chosen, ...]

    @property
    def front(self) -> Front:
        """Over all picks."""
        return front(self.outcomes)


def household_policies() -> dict[str, type[Policy]]:
    """Policies of this task by name, in the order of the registry."""
    return {n: p for n, p in POLICIES.items() if p.task is Task.HOUSEHOLD}


def baseline(reflex: bool = False) -> type[Policy]:
    """Who knows nothing, with a reflex or without."""
    return next(
        p
        for p in household_policies().values()
        if p.part is Part.BASELINE and p.has_reflex() is reflex
    )


def candidate(reflex: bool = False) -> type[Policy]:
    """Who acts on the estimate, with a reflex or without."""
    return next(
        p
        for p in household_policies().values()
        if p.part is Part.CANDIDATE and p.has_reflex() is reflex
    )


def labelled(table: Table, rmse: float, seed: int) -> list[Told]:
    """By speed: the label of each pick with that much noise, as an estimate."""
    rng = np.random.default_rng([seed, round(1e3 * rmse)])
    noisy = table.shore_a + rmse * rng.standard_normal(len(table.picks))
    half = NORMAL * rmse
    told = [Stiffness(float(s), float(s) - half, float(s) + half, 0.015) for s in noisy]
    return [told for _ in table.how.speeds]


def tried_on(
    tables: Tables, kind: type[Policy], told: Sequence[Told], reflex: tuple[int, int] | None = None
) -> list[Candidate]:
    """All settings of a policy on the tuning table."""
    settings = settings_of(kind, tables.budget, tables.few, tables.seed)
    return candidates(kind, settings, tables.tuning, told, reflex)


def judged(
    tables: Tables,
    kind: type[Policy],
    told: tuple[Sequence[Told], Sequence[Told]] | None = None,
    reflex: tuple[int, int] | None = None,
) -> Judged:
    """Tune a policy without each fold's families, and judge it on those.

    Parameters
    ----------
    tables
        To tune and to judge on.
    kind
        The policy.
    told
        What it is told on either table, by speed; the live estimates by default.
    reflex
        Places of lift and detection.
    """
    tuning, judging = (tables.tuning.told, tables.judged.told) if told is None else told
    tried = tried_on(tables, kind, tuning, reflex)

    @cache
    def outcomes(settings: tuple[tuple[str, float], ...]) -> Outcomes:
        its: Settings = dict(settings)
        speed = tables.judged.how.speeds.index(its["approach"])
        return swept(kind, its, tables.judged, judging[speed], reflex)

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
        its, which = outcomes(chosen[-1]), ask == fold
        dropped[:, which], damaged[:, which] = its.dropped[:, which], its.damaged[:, which]
    return Judged(Outcomes(dropped, damaged), tuple(chosen))


def ceiling(table: Table) -> Front:
    """The best approach, force and reflex of each very pick, found by looking at what they do.

    Nobody can do better, and nobody can have it: it is chosen on the very picks that it is judged
    on. Where a pick can be neither dropped nor damaged, it is; where not, the price of damage in
    drops decides, which makes a front.
    """
    forces = np.exp(np.linspace(np.log(table.how.forces[0]), np.log(table.how.forces[-1]), 60))
    grid = np.repeat(forces[:, None], len(table.picks), axis=1)
    reflexes = product(range(len(LIFTS)), range(len(DETECTION)), range(len(table.how.boosts)))
    acting = [None, *(Reflexed(*places) for places in reflexes)]
    found = [table.outcomes(v, grid, r) for v in range(len(table.how.speeds)) for r in acting]
    dropped = np.concatenate([f.dropped for f in found])
    damaged = np.concatenate([f.damaged for f in found])
    picks = np.arange(len(table.picks))
    points = []
    for price in (100.0, 0.01):
        best = np.argmin(dropped + price * damaged, axis=0)
        points.append((dropped[best, picks].mean(), damaged[best, picks].mean()))
    both = np.array(points)
    return Front(both[:, 0], both[:, 1])


def weights_of(table: Table, seed: int) -> NDArray[np.float64]:
    """Resamples of kinds and hands, the same for everybody: differences are paired."""
    groups = np.array([household_named(pick.kind).group for pick in table.picks])
    return resampled(table.kinds, table.hands, groups, RESAMPLES, seed)


def between(value: float, drawn: NDArray[np.float64]) -> Between:
    """A number with the middle 95 % of its resamples."""
    low, high = np.nanpercentile(drawn, [2.5, 97.5])
    return Between(value=value, low=float(low), high=float(high))


def drops(found: Judged, weights: NDArray[np.float64]) -> Between:
    """Share of drops where a tenth is damaged, in resamples as over all picks."""
    return between(float(found.front.drops_at()), front(found.outcomes, weights).drops_at())


def less(dropped: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.float64]:
    """By which share one drops less than another, -1 to 1: twice as much is -1, more too."""
    ratio = np.where(
        others > 0, dropped / np.maximum(others, 1e-9), np.where(dropped > 0, 2.0, 1.0)
    )
    gain: NDArray[np.float64] = np.clip(1 - ratio, -1.0, 1.0)
    return gain


def fewer(ours: Judged, theirs: Judged, weights: NDArray[np.float64] | None = None) -> Between:
    """By which share ours drops less where both damage a tenth.

    In each resample both are as bold as damages a tenth there: nothing that one of them damages
    more is hidden, and what the choice of their boldness leaves to chance is in the interval.
    How often such intervals hold a truth that is known: ``benchmarks/grasp_intervals.py``.

    Parameters
    ----------
    ours, theirs
        On the same picks.
    weights
        Of resamples; None for none.
    """
    value = float(less(ours.front.drops_at(), theirs.front.drops_at()))
    if weights is None:
        return Between(value=value, low=value, high=value)
    mine, others = (front(j.outcomes, weights).drops_at() for j in (ours, theirs))
    return between(value, less(mine, others))


def fewer_as_bold(ours: Judged, theirs: Judged, weights: NDArray[np.float64]) -> Between:
    """The same where in resamples both stay as bold as over all picks.

    What they damage then differs: each thing that ours damages more counts as one that it drops,
    and each that it damages less as one that it does not.
    """
    a, b = (int(np.argmin(np.abs(SCALES - scale_at(j.front)))) for j in (ours, theirs))
    mine, others = front(ours.outcomes, weights), front(theirs.outcomes, weights)
    # Over all picks both damage a tenth but for a step of the scale.
    apart = ours.front.damaged[a] - theirs.front.damaged[b]
    dropped = mine.dropped[a] + mine.damaged[a] - others.damaged[b] - apart
    return between(fewer(ours, theirs).value, less(dropped, others.dropped[b]))


def conditions() -> dict[str, tuple[int, int]]:
    """Places of every lift and detection, by what they are called."""
    return {
        f"{lift}, {1e3 * wait:g} ms": (a, b)
        for a, lift in enumerate(LIFTS)
        for b, wait in enumerate(DETECTION)
    }


def permuted(tables: Tables, count: int, mass: bool, damage: bool, seed: int) -> Between:
    """What stiffness still gains where things are given the weight or the limit of others.

    Everybody is tuned anew each time. The middle 95 % are over permutations.
    """
    names = sorted(set(tables.judged.kinds))
    rng = np.random.default_rng([seed, mass, damage])
    kinds = (baseline(), candidate())
    tried = {k.name: tried_on(tables, k, tables.tuning.told) for k in kinds}
    pressed = {k.name: _pressed(tables.tuning, k, tried[k.name]) for k in kinds}
    gains = []
    for _ in range(count):
        by_mass = dict(zip(names, rng.permutation(names), strict=True)) if mass else {}
        by_limit = dict(zip(names, rng.permutation(names), strict=True)) if damage else {}
        other = Tables(
            _given(tables.tuning, by_mass, by_limit), _given(tables.judged, by_mass, by_limit),
            tables.folds, tables.budget, tables.few, tables.seed,
        )  # fmt: skip
        its = []
        for kind in kinds:
            again = [
                Candidate(c.settings, other.tuning.judge(peak, hold, SCATTER))
                for c, (peak, hold) in zip(tried[kind.name], pressed[kind.name], strict=True)
            ]
            its.append(_by_fold(other, again, _judge(other, kind)))
        theirs, ours = its
        gains.append(fewer(ours, theirs).value)
    return between(float(np.mean(gains)), np.array(gains))


def _judge(tables: Tables, kind: type[Policy]) -> Callable[[Chosen], Outcomes]:
    def outcomes(chosen: Chosen) -> Outcomes:
        speed = tables.judged.how.speeds.index(chosen.settings["approach"])
        return swept(kind, chosen.settings, tables.judged, tables.judged.told[speed], None)

    return outcomes


def _pressed(
    table: Table, kind: type[Policy], tried: Sequence[Candidate]
) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    found = []
    for one in tried:
        speed = speed_place(table, one.settings)
        forces = forces_of(kind, one.settings, table, table.told[speed])
        found.append(table.pressed(speed, SCALES[:, None] * forces))
    return found


def _given(table: Table, by_mass: Mapping[str, str], by_limit: Mapping[str, str]) -> Table:
    """The same picks with what other kinds weigh and bear, specimen by specimen."""
    place = {(p.kind, p.hand, p.specimen): i for i, p in enumerate(table.picks)}

    def of(by: Mapping[str, str]) -> NDArray[np.intp]:
        return np.array([place[by.get(p.kind, p.kind), p.hand, p.specimen] for p in table.picks])

    return table.otherwise(table.needed[of(by_mass)], table.limit[of(by_limit)])
