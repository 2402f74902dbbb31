"""Scores of grasp policies on simulated picks of household objects that were not used for tuning.

Policies get live estimates, or true labels with random errors. They may have a slip reflex.
Controls give objects the weight or damage limit of others.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from firstcontact.grasp import POLICIES, Policy
from firstcontact.grasp.policy import PolicyRole, Task
from firstcontact.testing import make_estimate
from firstcontact.twin.household import Quantity, household_named
from firstcontact_lab.grasping.picks import LIFTS
from firstcontact_lab.grasping.results import Between, ChosenSettings
from firstcontact_lab.grasping.table import DETECTION, ClosingTable, Outcomes, Reflexed, Values
from firstcontact_lab.grasping.tuning import (
    SCALES,
    SCATTER,
    Candidate,
    Front,
    PickEstimates,
    choose,
    find_scale,
    folds,
    front,
    policy_forces,
    policy_settings,
    resampled,
    speed_place,
    swept,
)
from firstcontact_lab.study.scores import NORMAL

RESAMPLES = 1000
#: RMSE of the noise that is added to labels, Shore A; 0 for exact labels.
NOISES = (0.0, 3.0, 5.0, 10.0)
#: Kind of lift and latency of the slip detection in full closings with a slip reflex.
FULL = ("gradual", DETECTION[0])
#: Factors by which the estimated limits, masses and friction coefficients are multiplied.
LIMITS, MASSES, FRICTIONS = (0.7, 1.4), (0.8, 1.25), (0.8, 1.25)
#: Number of draws with random factors on the limits, and standard deviation of these factors.
DRAWS, SPREAD = 8, 0.3

#: Function from the name of an object to the settings of a policy that is judged on it.
SettingsOf = Callable[[str], Mapping[str, float]]


@dataclass(frozen=True, slots=True)
class Tables:
    """Two tables of simulated outcomes: one to tune policies, one to judge them.

    They have different hands and objects.
    """

    tuning: ClosingTable
    judged: ClosingTable
    folds: int
    budget: int
    few: bool
    seed: int


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """Outcomes of a policy on objects and hands for which its settings were not tuned."""

    outcomes: Outcomes
    chosen: tuple[ChosenSettings, ...]

    @property
    def front(self) -> Front:
        return front(self.outcomes)


def household_policies() -> dict[str, type[Policy]]:
    return {n: p for n, p in POLICIES.items() if p.task is Task.HOUSEHOLD}


def _policy(part: PolicyRole, reflex: bool) -> type[Policy]:
    policies = household_policies().values()
    return next(p for p in policies if p.part is part and p.has_reflex() is reflex)


def baseline(reflex: bool = False) -> type[Policy]:
    """Return the class of the best policy that ignores stiffness, with or without a slip reflex."""
    return _policy(PolicyRole.BASELINE, reflex)


def candidate(reflex: bool = False) -> type[Policy]:
    """Return the class of the policy that uses the stiffness, with or without a slip reflex."""
    return _policy(PolicyRole.CANDIDATE, reflex)


def labelled(table: ClosingTable, rmse: float, seed: int) -> list[PickEstimates]:
    """Return the true Shore A plus noise in place of estimates: one list per approach speed.

    All lists are equal. ``rmse`` is the standard deviation of the noise, Shore A.
    """
    rng = np.random.default_rng([seed, round(1e3 * rmse)])
    noisy = table.shore_a + rmse * rng.standard_normal(len(table.picks))
    half = NORMAL * rmse
    estimates = [make_estimate(float(s), float(s) - half, float(s) + half) for s in noisy]
    return [estimates for _ in table.how.speeds]


def tried_on(
    tables: Tables,
    kind: type[Policy],
    estimates: Sequence[PickEstimates],
    reflex: tuple[int, int] | None = None,
) -> list[Candidate]:
    settings = policy_settings(kind, tables.budget, tables.few, tables.seed)
    return [
        Candidate(one, swept(kind, one, tables.tuning, estimates, reflex, SCATTER))
        for one in settings
    ]


def judged(
    tables: Tables,
    kind: type[Policy],
    estimates: tuple[Sequence[PickEstimates], Sequence[PickEstimates]] | None = None,
    reflex: tuple[int, int] | None = None,
) -> Judged:
    """Score a policy on each fold of objects, with the settings that were best on the other folds.

    ``estimates`` are those for tuning and for judging; by default those of the tables. ``reflex``
    holds the indices of the lift and of the latency, for a policy with a slip reflex.
    """
    tuning, judging = estimates or (tables.tuning.estimates, tables.judged.estimates)
    tried = tried_on(tables, kind, tuning, reflex)

    @cache
    def outcomes(settings: tuple[tuple[str, float], ...]) -> Outcomes:
        return swept(kind, dict(settings), tables.judged, judging, reflex)

    return _by_fold(tables, tried, lambda chosen: outcomes(tuple(chosen.settings.items())))


def _by_fold(
    tables: Tables, tried: Sequence[Candidate], outcomes: Callable[[ChosenSettings], Outcomes]
) -> Judged:
    fold_of = folds(sorted(set(tables.tuning.kinds) | set(tables.judged.kinds)), tables.folds)
    learn = np.array([fold_of[k] for k in tables.tuning.kinds])
    ask = np.array([fold_of[k] for k in tables.judged.kinds])
    dropped, damaged = np.zeros((2, len(SCALES), len(ask)))
    chosen = []
    for fold in range(tables.folds):
        chosen.append(choose(tried, learn != fold))
        outcome, selected = outcomes(chosen[-1]), ask == fold
        dropped[:, selected] = outcome.dropped[:, selected]
        damaged[:, selected] = outcome.damaged[:, selected]
    return Judged(Outcomes(dropped, damaged), tuple(chosen))


@dataclass(frozen=True, slots=True, eq=False)
class Judgement:
    """Outcomes of all policies on the picks that were not used for tuning."""

    plain: Mapping[str, Judged]
    reflexes: Mapping[str, tuple[Judged, Judged]]
    fold_of: Mapping[str, int]

    @property
    def blind(self) -> Judged:
        return self.plain[baseline().name]

    @property
    def ours(self) -> Judged:
        return self.plain[candidate().name]

    @property
    def everyone(self) -> dict[str, Judged]:
        """Outcomes of each policy by its name.

        A slip reflex has the lift and latency of ``FULL``.
        """
        place = (list(LIFTS).index(FULL[0]), DETECTION.index(FULL[1]))
        full = next(name for name, at in conditions().items() if at == place)
        names = (baseline(True).name, candidate(True).name)
        return {**self.plain, **dict(zip(names, self.reflexes[full], strict=True))}

    def chosen(self) -> dict[str, SettingsOf]:
        """Return a function for each policy name.

        It maps an object to the settings tuned without it.
        """

        def of_policy(policy: Judged) -> SettingsOf:
            return lambda kind: policy.chosen[self.fold_of[kind]].settings

        return {name: of_policy(policy) for name, policy in self.everyone.items()}


def judgement(tables: Tables) -> Judgement:
    plain = {n: judged(tables, k) for n, k in household_policies().items() if not k.has_reflex()}
    for noise in NOISES:
        estimates = (
            labelled(tables.tuning, noise, tables.seed),
            labelled(tables.judged, noise, tables.seed + 1),
        )
        name = "label" if noise == 0 else f"label_rmse_{noise:g}"
        plain[name] = judged(tables, candidate(), estimates)
    reflexes = {
        name: (judged(tables, baseline(True), None, at), judged(tables, candidate(True), None, at))
        for name, at in conditions().items()
    }
    return Judgement(plain, reflexes, folds(sorted(set(tables.judged.kinds)), tables.folds))


def conditions() -> dict[str, tuple[int, int]]:
    """Return the indices (lift, latency) of each condition for slip reflexes, by its name.

    An example of a name is "abrupt, 100 ms".
    """
    return {
        f"{lift}, {1e3 * wait:g} ms": (a, b)
        for a, lift in enumerate(LIFTS)
        for b, wait in enumerate(DETECTION)
    }


def ceiling(table: ClosingTable) -> Front:
    """Return the best shares of drops and damage that any policy could reach.

    For this, each pick gets the speed, force and reflex that suit it best.
    """
    forces = np.exp(np.linspace(np.log(table.how.forces[0]), np.log(table.how.forces[-1]), 60))
    grid = np.repeat(forces[:, None], len(table.picks), axis=1)
    reflexes = product(range(len(LIFTS)), range(len(DETECTION)), range(len(table.how.boosts)))
    acting = [None, *(Reflexed(*places) for places in reflexes)]
    outcomes = [table.outcomes(v, grid, r) for v in range(len(table.how.speeds)) for r in acting]
    dropped = np.concatenate([f.dropped for f in outcomes])
    damaged = np.concatenate([f.damaged for f in outcomes])
    picks = np.arange(len(table.picks))
    points = []
    for price in (100.0, 0.01):
        best = np.argmin(dropped + price * damaged, axis=0)
        points.append((dropped[best, picks].mean(), damaged[best, picks].mean()))
    return Front(*np.array(points).T)


def resample_weights(table: ClosingTable, seed: int) -> Values:
    """Return bootstrap weights, shape (picks, resamples), that draw objects and hands again."""
    groups = np.array([household_named(pick.kind).group for pick in table.picks])
    return resampled(table.kinds, table.hands, groups, RESAMPLES, seed)


def between(value: float, drawn: Values) -> Between:
    """Return ``value`` with an interval: the middle 95 % of its bootstrap values ``drawn``."""
    low, high = np.nanpercentile(drawn, [2.5, 97.5])
    return Between(value=value, low=float(low), high=float(high))


def drops(policy: Judged, weights: Values) -> Between:
    """Return the share of objects that a policy drops at 10 % damage, with its interval."""
    return between(float(policy.front.drop_share()), front(policy.outcomes, weights).drop_share())


def less(dropped: Values, theirs: Values) -> Values:
    """Return the relative reduction of drops, 1 - ``dropped`` / ``theirs``, clipped to -1 to 1."""
    ratio = np.where(
        theirs > 0, dropped / np.maximum(theirs, 1e-9), np.where(dropped > 0, 2.0, 1.0)
    )
    return np.asarray(np.clip(1 - ratio, -1.0, 1.0))


def fewer(ours: Judged, theirs: Judged, weights: Values | None = None) -> Between:
    """Return by which share fewer objects drop with policy ``ours`` than with ``theirs``.

    Forces of both policies are scaled until they damage 10 % of the objects. Without ``weights``,
    the result has no interval.
    """
    value = float(less(ours.front.drop_share(), theirs.front.drop_share()))
    if weights is None:
        return Between(value=value, low=value, high=value)
    mine, others = (front(j.outcomes, weights).drop_share() for j in (ours, theirs))
    return between(value, less(mine, others))


def fewer_as_bold(ours: Judged, theirs: Judged, weights: Values) -> Between:
    """Return the reduction of drops as :func:`fewer`, but scale the forces once on all picks.

    :func:`fewer` instead scales them again in each bootstrap resample. So this interval also holds
    the scatter of the damage.
    """
    a, b = (int(np.argmin(np.abs(SCALES - find_scale(j.front)))) for j in (ours, theirs))
    mine, others = front(ours.outcomes, weights), front(theirs.outcomes, weights)
    # Over all picks both policies damage a tenth, apart from the steps between scales.
    apart = ours.front.damaged[a] - theirs.front.damaged[b]
    dropped = mine.dropped[a] + mine.damaged[a] - others.damaged[b] - apart
    return between(fewer(ours, theirs).value, less(dropped, others.dropped[b]))


def permuted(tables: Tables, count: int, mass: bool, damage: bool, seed: int) -> Between:
    """Return the reduction of drops after objects swapped their weights or damage limits at random.

    With ``mass`` they swap weights, with ``damage`` damage limits. The value is the mean over
    ``count`` random swaps, and the interval holds the middle 95 % of them.
    """
    names = sorted(set(tables.judged.kinds))
    rng = np.random.default_rng([seed, mass, damage])
    kinds = (baseline(), candidate())
    tried = {k.name: tried_on(tables, k, tables.tuning.estimates) for k in kinds}
    pressed = {k.name: _pressed(tables.tuning, k, tried[k.name]) for k in kinds}
    gains = []
    for _ in range(count):
        by_mass = dict(zip(names, rng.permutation(names), strict=True)) if mass else {}
        by_limit = dict(zip(names, rng.permutation(names), strict=True)) if damage else {}
        tuning, judging = (_given(t, by_mass, by_limit) for t in (tables.tuning, tables.judged))
        other = replace(tables, tuning=tuning, judged=judging)

        def retuned(
            kind: type[Policy], tuning: ClosingTable = tuning, other: Tables = other
        ) -> Judged:
            again = [
                Candidate(c.settings, tuning.judge(peak, hold, SCATTER))
                for c, (peak, hold) in zip(tried[kind.name], pressed[kind.name], strict=True)
            ]
            table = other.judged
            return _by_fold(
                other, again, lambda one: swept(kind, one.settings, table, table.estimates)
            )

        theirs, ours = map(retuned, kinds)
        gains.append(fewer(ours, theirs).value)
    return between(float(np.mean(gains)), np.array(gains))


def _pressed(
    table: ClosingTable, kind: type[Policy], tried: Sequence[Candidate]
) -> list[tuple[Values, Values]]:
    pressed = []
    for one in tried:
        speed = speed_place(table, one.settings)
        forces = policy_forces(kind, one.settings, table, table.estimates[speed])
        pressed.append(table.pressed(speed, SCALES[:, None] * forces))
    return pressed


def _given(
    table: ClosingTable, by_mass: Mapping[str, str], by_limit: Mapping[str, str]
) -> ClosingTable:
    """Return the table with the holding forces and damage limits of some objects replaced.

    ``by_mass`` and ``by_limit`` map the name of an object to the object whose value it gets.
    """
    place = {(p.kind, p.hand, p.specimen): i for i, p in enumerate(table.picks)}

    def indices(by: Mapping[str, str]) -> NDArray[np.intp]:
        return np.array([place[by.get(p.kind, p.kind), p.hand, p.specimen] for p in table.picks])

    return table.otherwise(table.needed[indices(by_mass)], table.limit[indices(by_limit)])


def sensitivity(tables: Tables) -> dict[str, Between]:
    """Return the reduction of drops if the assumed limits, masses or frictions were different.

    Each key describes one change, such as "estimated masses × 2".
    """
    gains = {}
    names = sorted(set(tables.judged.kinds) | set(tables.tuning.kinds))
    for title, of, factors in (
        ("limits", "limit", LIMITS),
        ("masses", "mass", MASSES),
        ("frictions", "friction", FRICTIONS),
    ):
        for factor in factors:
            same = dict.fromkeys(names, factor)
            gains[f"estimated {title} × {factor:g}"] = _gain(tables, of, same, intervals=True)
    rng = np.random.default_rng([tables.seed, 7])
    drawn = []
    for _ in range(DRAWS):
        by_kind = dict(zip(names, np.exp(SPREAD * rng.standard_normal(len(names))), strict=True))
        drawn.append(_gain(tables, "limit", by_kind, intervals=False).value)
    gains[f"each estimated limit off by {100 * SPREAD:.0f} % by chance, {DRAWS} draws"] = Between(
        value=float(np.mean(drawn)), low=min(drawn), high=max(drawn)
    )
    return gains


def _gain(tables: Tables, of: str, factors: Mapping[str, float], *, intervals: bool) -> Between:
    """Return the reduction of drops after the property ``of`` of each object is multiplied.

    ``of`` is "limit", "mass" or "friction". ``factors`` are by object name. Values that were
    measured, not assumed, stay the same.
    """
    tuning, judging = (_changed(t, of, factors) for t in (tables.tuning, tables.judged))
    other = replace(tables, tuning=tuning, judged=judging)
    weights = resample_weights(other.judged, other.seed) if intervals else None
    return fewer(judged(other, candidate()), judged(other, baseline()), weights)


def _changed(table: ClosingTable, of: str, by_kind: Mapping[str, float]) -> ClosingTable:
    factors: Values = np.ones(len(table.picks))
    for place, pick in enumerate(table.picks):
        quantity: Quantity | None = getattr(household_named(pick.kind).numbers, of)
        if quantity is not None and quantity.estimated:
            factors[place] = by_kind[pick.kind]
    if of == "limit":
        return table.otherwise(limit=table.limit * factors)
    return table.otherwise(needed=table.needed * (factors if of == "mass" else 1 / factors))
