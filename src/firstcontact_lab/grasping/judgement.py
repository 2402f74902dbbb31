"""Scores of grasp policies on simulated picks of household objects, for ``grasp-study``.

The objects and hands are others than those used for tuning. A policy gets live estimates, or true
Shore A values with random errors. It may have a slip reflex. In control experiments, objects have
the weights or damage limits of other objects.
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
from firstcontact_lab.grasping.table import DETECTION, ClosingTable, Outcomes, ReflexIndices, Values
from firstcontact_lab.grasping.tuning import (
    SCALES,
    SCATTER,
    Candidate,
    Front,
    PickEstimates,
    approach_speed_index,
    assign_folds,
    bootstrap_weights,
    choose_settings,
    compute_front,
    find_scale,
    policy_forces,
    policy_outcomes,
    policy_settings,
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
    """Two tables of simulated closings: one to tune policies, one to judge them.

    The tables share no hand and no specimen. ``folds`` is the number of groups of objects, and
    ``budget`` the largest number of settings to try.
    """

    tuning: ClosingTable
    judged: ClosingTable
    folds: int
    budget: int
    few: bool
    seed: int


@dataclass(frozen=True, slots=True, eq=False)
class JudgedPolicy:
    """Outcomes of a policy on objects and hands for which its settings were not tuned.

    ``chosen`` has the settings for each fold, tuned on the other folds.
    """

    outcomes: Outcomes
    chosen: tuple[ChosenSettings, ...]

    @property
    def front(self) -> Front:
        return compute_front(self.outcomes)


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


def noisy_labels(table: ClosingTable, rmse: float, seed: int) -> list[PickEstimates]:
    """Return the true Shore A of each pick plus random noise, in place of live estimates.

    The result has one list for each approach speed, all with equal values. ``rmse`` is the standard
    deviation of the noise, Shore A.
    """
    rng = np.random.default_rng([seed, round(1e3 * rmse)])
    noisy = table.shore_a + rmse * rng.standard_normal(len(table.picks))
    half = NORMAL * rmse
    estimates = [make_estimate(float(s), float(s) - half, float(s) + half) for s in noisy]
    return [estimates for _ in table.how.speeds]


def try_settings(
    tables: Tables,
    kind: type[Policy],
    estimates: Sequence[PickEstimates],
    reflex: tuple[int, int] | None = None,
) -> list[Candidate]:
    settings = policy_settings(kind, tables.budget, tables.few, tables.seed)
    return [
        Candidate(one, policy_outcomes(kind, one, tables.tuning, estimates, reflex, SCATTER))
        for one in settings
    ]


def judge_policy(
    tables: Tables,
    kind: type[Policy],
    estimates: tuple[Sequence[PickEstimates], Sequence[PickEstimates]] | None = None,
    reflex: tuple[int, int] | None = None,
) -> JudgedPolicy:
    """Score a policy on each fold of objects, with the settings that were best on the other folds.

    ``estimates`` is (estimates for tuning, estimates for judging), by default those of the tables.
    ``reflex`` is (lift, latency): indices into ``LIFTS`` and ``DETECTION``. Only policies with a
    slip reflex need it.
    """
    tuning, judging = estimates or (tables.tuning.estimates, tables.judged.estimates)
    tried = try_settings(tables, kind, tuning, reflex)

    @cache
    def outcomes(settings: tuple[tuple[str, float], ...]) -> Outcomes:
        return policy_outcomes(kind, dict(settings), tables.judged, judging, reflex)

    return _judge_by_fold(tables, tried, lambda chosen: outcomes(tuple(chosen.settings.items())))


def _judge_by_fold(
    tables: Tables, tried: Sequence[Candidate], outcomes: Callable[[ChosenSettings], Outcomes]
) -> JudgedPolicy:
    fold_of = assign_folds(
        sorted(set(tables.tuning.kinds) | set(tables.judged.kinds)), tables.folds
    )
    learn = np.array([fold_of[k] for k in tables.tuning.kinds])
    ask = np.array([fold_of[k] for k in tables.judged.kinds])
    dropped, damaged = np.zeros((2, len(SCALES), len(ask)))
    chosen = []
    for fold in range(tables.folds):
        chosen.append(choose_settings(tried, learn != fold))
        outcome, selected = outcomes(chosen[-1]), ask == fold
        dropped[:, selected] = outcome.dropped[:, selected]
        damaged[:, selected] = outcome.damaged[:, selected]
    return JudgedPolicy(Outcomes(dropped, damaged), tuple(chosen))


@dataclass(frozen=True, slots=True, eq=False)
class PolicyJudgements:
    """Outcomes of all policies on picks that were not used for tuning.

    ``plain`` has the policies without a slip reflex, by name. ``reflexes`` has (baseline,
    candidate) with a slip reflex, by condition. ``fold_of`` maps each object to its fold.
    """

    plain: Mapping[str, JudgedPolicy]
    reflexes: Mapping[str, tuple[JudgedPolicy, JudgedPolicy]]
    fold_of: Mapping[str, int]

    @property
    def blind(self) -> JudgedPolicy:
        return self.plain[baseline().name]

    @property
    def ours(self) -> JudgedPolicy:
        return self.plain[candidate().name]

    @property
    def everyone(self) -> dict[str, JudgedPolicy]:
        """Outcomes of each policy, by the policy's name.

        Policies with a slip reflex are those for the lift and latency of ``FULL``.
        """
        place = (list(LIFTS).index(FULL[0]), DETECTION.index(FULL[1]))
        full = next(name for name, at in reflex_conditions().items() if at == place)
        names = (baseline(True).name, candidate(True).name)
        return {**self.plain, **dict(zip(names, self.reflexes[full], strict=True))}

    def chosen(self) -> dict[str, SettingsOf]:
        """Return a function for each policy name, which maps an object to settings.

        The settings were tuned without this object.
        """

        def of_policy(policy: JudgedPolicy) -> SettingsOf:
            return lambda kind: policy.chosen[self.fold_of[kind]].settings

        return {name: of_policy(policy) for name, policy in self.everyone.items()}


def judge_policies(tables: Tables) -> PolicyJudgements:
    plain = {
        n: judge_policy(tables, k) for n, k in household_policies().items() if not k.has_reflex()
    }
    for noise in NOISES:
        estimates = (
            noisy_labels(tables.tuning, noise, tables.seed),
            noisy_labels(tables.judged, noise, tables.seed + 1),
        )
        name = "label" if noise == 0 else f"label_rmse_{noise:g}"
        plain[name] = judge_policy(tables, candidate(), estimates)
    reflexes = {
        name: (
            judge_policy(tables, baseline(True), None, at),
            judge_policy(tables, candidate(True), None, at),
        )
        for name, at in reflex_conditions().items()
    }
    return PolicyJudgements(
        plain, reflexes, assign_folds(sorted(set(tables.judged.kinds)), tables.folds)
    )


def reflex_conditions() -> dict[str, tuple[int, int]]:
    """Return (lift, latency) for each condition of a slip reflex, by the name of the condition.

    The numbers are indices into ``LIFTS`` and ``DETECTION``. A name is, for example, "abrupt, 100
    ms".
    """
    return {
        f"{lift}, {1e3 * wait:g} ms": (a, b)
        for a, lift in enumerate(LIFTS)
        for b, wait in enumerate(DETECTION)
    }


def best_possible_front(table: ClosingTable) -> Front:
    """Return the smallest shares of drops and damage that any policy could reach.

    Each pick gets the approach speed, grip force and slip reflex that suit it best.
    """
    forces = np.exp(np.linspace(np.log(table.how.forces[0]), np.log(table.how.forces[-1]), 60))
    grid = np.repeat(forces[:, None], len(table.picks), axis=1)
    reflexes = product(range(len(LIFTS)), range(len(DETECTION)), range(len(table.how.boosts)))
    acting = [None, *(ReflexIndices(*places) for places in reflexes)]
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
    """Return the weight of each pick in bootstrap resamples, shape (picks, resamples).

    Each resample draws objects and hands at random, with replacement.
    """
    groups = np.array([household_named(pick.kind).group for pick in table.picks])
    return bootstrap_weights(table.kinds, table.hands, groups, RESAMPLES, seed)


def with_interval(value: float, drawn: Values) -> Between:
    """Return ``value`` with a 95 % interval: the middle 95 % of the bootstrap values ``drawn``."""
    low, high = np.nanpercentile(drawn, [2.5, 97.5])
    return Between(value=value, low=float(low), high=float(high))


def drop_share(policy: JudgedPolicy, weights: Values) -> Between:
    """Return the share of picks that a policy drops at 10 % damage, with a 95 % interval."""
    return with_interval(
        float(policy.front.drop_share()), compute_front(policy.outcomes, weights).drop_share()
    )


def relative_reduction(dropped: Values, theirs: Values) -> Values:
    """Return the relative reduction of drops, 1 - ``dropped`` / ``theirs``, clipped to -1 to 1.

    Both are shares of dropped picks: ``theirs`` is that of the reference policy.
    """
    ratio = np.where(
        theirs > 0, dropped / np.maximum(theirs, 1e-9), np.where(dropped > 0, 2.0, 1.0)
    )
    return np.asarray(np.clip(1 - ratio, -1.0, 1.0))


def drop_reduction(
    ours: JudgedPolicy, theirs: JudgedPolicy, weights: Values | None = None
) -> Between:
    """Return the relative reduction of drops from policy ``theirs`` to policy ``ours``.

    The forces of both policies are scaled until they damage 10 % of the picks. ``weights`` are
    those of :func:`resample_weights`. Without them, the interval has no width.
    """
    value = float(relative_reduction(ours.front.drop_share(), theirs.front.drop_share()))
    if weights is None:
        return Between(value=value, low=value, high=value)
    mine, others = (compute_front(j.outcomes, weights).drop_share() for j in (ours, theirs))
    return with_interval(value, relative_reduction(mine, others))


def drop_reduction_at_fixed_scale(
    ours: JudgedPolicy, theirs: JudgedPolicy, weights: Values
) -> Between:
    """Return the reduction of drops as :func:`drop_reduction`, with forces scaled only once.

    The scale that equalises the damage is found on all picks, not in each bootstrap resample. The
    interval therefore includes the random variation of the damage.
    """
    a, b = (int(np.argmin(np.abs(SCALES - find_scale(j.front)))) for j in (ours, theirs))
    mine, others = compute_front(ours.outcomes, weights), compute_front(theirs.outcomes, weights)
    # Over all picks both policies damage a tenth, apart from the steps between scales.
    apart = ours.front.damaged[a] - theirs.front.damaged[b]
    dropped = mine.dropped[a] + mine.damaged[a] - others.damaged[b] - apart
    return with_interval(
        drop_reduction(ours, theirs).value, relative_reduction(dropped, others.dropped[b])
    )


def reduction_after_swaps(
    tables: Tables, count: int, mass: bool, damage: bool, seed: int
) -> Between:
    """Return the reduction of drops after objects swapped their weights or damage limits at random.

    With ``mass`` objects swap weights, with ``damage`` they swap damage limits. The value is the
    mean over ``count`` random swaps. The interval holds the middle 95 % of the swaps.
    """
    names = sorted(set(tables.judged.kinds))
    rng = np.random.default_rng([seed, mass, damage])
    kinds = (baseline(), candidate())
    tried = {k.name: try_settings(tables, k, tables.tuning.estimates) for k in kinds}
    pressed = {k.name: _simulated_forces(tables.tuning, k, tried[k.name]) for k in kinds}
    gains = []
    for _ in range(count):
        by_mass = dict(zip(names, rng.permutation(names), strict=True)) if mass else {}
        by_limit = dict(zip(names, rng.permutation(names), strict=True)) if damage else {}
        tuning, judging = (
            _swap_properties(t, by_mass, by_limit) for t in (tables.tuning, tables.judged)
        )
        other = replace(tables, tuning=tuning, judged=judging)

        def retuned(
            kind: type[Policy], tuning: ClosingTable = tuning, other: Tables = other
        ) -> JudgedPolicy:
            again = [
                Candidate(c.settings, tuning.judge(peak, hold, SCATTER))
                for c, (peak, hold) in zip(tried[kind.name], pressed[kind.name], strict=True)
            ]
            table = other.judged
            return _judge_by_fold(
                other,
                again,
                lambda one: policy_outcomes(kind, one.settings, table, table.estimates),
            )

        theirs, ours = map(retuned, kinds)
        gains.append(drop_reduction(ours, theirs).value)
    return with_interval(float(np.mean(gains)), np.array(gains))


def _simulated_forces(
    table: ClosingTable, kind: type[Policy], tried: Sequence[Candidate]
) -> list[tuple[Values, Values]]:
    pressed = []
    for one in tried:
        speed = approach_speed_index(table, one.settings)
        forces = policy_forces(kind, one.settings, table, table.estimates[speed])
        pressed.append(table.interpolate_forces(speed, SCALES[:, None] * forces))
    return pressed


def _swap_properties(
    table: ClosingTable, by_mass: Mapping[str, str], by_limit: Mapping[str, str]
) -> ClosingTable:
    """Return the table with the holding forces and damage limits of some objects replaced.

    ``by_mass`` and ``by_limit`` map the name of an object to the name of the object whose holding
    force or limit it gets.
    """
    place = {(p.kind, p.hand, p.specimen): i for i, p in enumerate(table.picks)}

    def indices(by: Mapping[str, str]) -> NDArray[np.intp]:
        return np.array([place[by.get(p.kind, p.kind), p.hand, p.specimen] for p in table.picks])

    return table.with_properties(table.needed[indices(by_mass)], table.limit[indices(by_limit)])


def reductions_by_assumption(tables: Tables) -> dict[str, Between]:
    """Return the reduction of drops if assumed limits, masses or frictions were different.

    Each key describes one change, such as "estimated masses × 1.25".
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
            gains[f"estimated {title} × {factor:g}"] = _reduction_if_scaled(
                tables, of, same, intervals=True
            )
    rng = np.random.default_rng([tables.seed, 7])
    drawn = []
    for _ in range(DRAWS):
        by_kind = dict(zip(names, np.exp(SPREAD * rng.standard_normal(len(names))), strict=True))
        drawn.append(_reduction_if_scaled(tables, "limit", by_kind, intervals=False).value)
    gains[f"each estimated limit off by {100 * SPREAD:.0f} % by chance, {DRAWS} draws"] = Between(
        value=float(np.mean(drawn)), low=min(drawn), high=max(drawn)
    )
    return gains


def _reduction_if_scaled(
    tables: Tables, of: str, factors: Mapping[str, float], *, intervals: bool
) -> Between:
    """Return the reduction of drops after multiplying an assumed property of each object.

    The property ``of`` is "limit", "mass" or "friction". ``factors`` maps the name of an object to
    its factor. Measured properties stay unchanged.
    """
    tuning, judging = (_scale_property(t, of, factors) for t in (tables.tuning, tables.judged))
    other = replace(tables, tuning=tuning, judged=judging)
    weights = resample_weights(other.judged, other.seed) if intervals else None
    return drop_reduction(
        judge_policy(other, candidate()), judge_policy(other, baseline()), weights
    )


def _scale_property(table: ClosingTable, of: str, by_kind: Mapping[str, float]) -> ClosingTable:
    factors: Values = np.ones(len(table.picks))
    for place, pick in enumerate(table.picks):
        quantity: Quantity | None = getattr(household_named(pick.kind).numbers, of)
        if quantity is not None and quantity.estimated:
            factors[place] = by_kind[pick.kind]
    if of == "limit":
        return table.with_properties(limit=table.limit * factors)
    return table.with_properties(needed=table.needed * (factors if of == "mass" else 1 / factors))
