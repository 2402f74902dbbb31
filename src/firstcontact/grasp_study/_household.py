"""The household's part of the study: hands, tables, tuning, judged closings, numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.jobs import Runner
from firstcontact.grasp.policies.registry import POLICIES
from firstcontact.grasp.policy import Policy
from firstcontact.grasp_study._approach import Pick
from firstcontact.grasp_study._branches import (
    DETECTION,
    LIFTS,
    Branches,
    Branching,
    branches,
)
from firstcontact.grasp_study._estimates import by_object, estimates
from firstcontact.grasp_study._families import FAMILIES, folds
from firstcontact.grasp_study._front import DAMAGE, TUNED
from firstcontact.grasp_study._household_numbers import (
    Judged,
    Tables,
    baseline,
    between,
    candidate,
    ceiling,
    conditions,
    drops,
    fewer,
    fewer_as_bold,
    household_policies,
    judged,
    labelled,
    permuted,
    weights_of,
)
from firstcontact.grasp_study._own_hand import HandSeed, OwnHand, own_hand
from firstcontact.grasp_study._real import RealJob, RealRow, real
from firstcontact.grasp_study._sensitivity import sensitivity
from firstcontact.grasp_study._table import Table
from firstcontact.grasp_study.results import (
    Between,
    ChosenSettings,
    FrontPoints,
    Household,
    RealClosings,
    Reflexes,
    TunedOn,
)
from firstcontact.grasp_study.settings import HouseholdSettings

#: What was to be reached.
TARGET = 0.35
#: RMSE of labels with noise, Shore A: 0 is the label.
NOISES = (0.0, 3.0, 5.0, 10.0)
#: Lift and detection of the closings in full that have a reflex.
FULL = ("gradual", DETECTION[0])
OwnHands = dict[tuple[int, float], OwnHand]


@dataclass(frozen=True, slots=True, eq=False)
class HouseholdWork:
    """What is found, and what a film needs beside it."""

    results: Household
    own: OwnHands
    chosen: Mapping[str, Callable[[str], Mapping[str, float]]]


def household(
    settings: HouseholdSettings, seed: int, runner: Runner, stage: Callable[[str], object]
) -> HouseholdWork:
    """Run it all.

    Parameters
    ----------
    settings
        Size.
    seed
        Of everything.
    runner
        Does the closings.
    stage
        Is told what comes next.
    """
    how = Branching(settings.speeds, settings.forces, settings.boosts)
    tuning_hands, judged_hands = settings.hands_of(seed)
    stage("own hands")
    hands = [HandSeed(h, v) for h in (*tuning_hands, *judged_hands) for v in how.speeds]
    made = runner.map(own_hand, hands, settings.blocks)
    own: OwnHands = {(h.seed, h.speed): o for h, o in zip(hands, made, strict=True)}

    def table(title: str, seeds: Sequence[int], specimens: Sequence[int]) -> list[Branches]:
        stage(title)
        picks = [Pick(k, h, s) for k in settings.kinds for h in seeds for s in specimens]
        return runner.map(branches, [(p, v) for p in picks for v in how.speeds], own, how)

    tuning = table("closings to tune on", tuning_hands, settings.tuning_specimens)
    rows = table("closings to judge", judged_hands, settings.judged_specimens)
    stage("tuning")
    tables = Tables(
        Table.of(tuning, how), Table.of(rows, how), settings.folds, settings.budget,
        settings.few, seed,
    )  # fmt: skip
    return _found(tables, rows, own, settings, runner, stage)


def _found(
    tables: Tables,
    rows: Sequence[Branches],
    own: OwnHands,
    settings: HouseholdSettings,
    runner: Runner,
    stage: Callable[[str], object],
) -> HouseholdWork:
    table, seed = tables.judged, tables.seed
    weights = weights_of(table, seed)
    plain = {n: judged(tables, k) for n, k in household_policies().items() if not k.has_reflex()}
    for noise in NOISES:
        told = (labelled(tables.tuning, noise, seed), labelled(table, noise, seed + 1))
        plain[_noise(noise)] = judged(tables, candidate(), told)
    blind, ours = plain[baseline().name], plain[candidate().name]
    reflexes = {
        name: (judged(tables, baseline(True), None, at), judged(tables, candidate(True), None, at))
        for name, at in conditions().items()
    }
    full = conditions_name(FULL)
    everyone = {
        **plain,
        **dict(zip((baseline(True).name, candidate(True).name), reflexes[full], strict=True)),
    }
    fold_of = folds(sorted(set(table.kinds)), tables.folds)

    def settings_for(found: Judged) -> Callable[[str], Mapping[str, float]]:
        return lambda kind: found.chosen[fold_of[kind]].settings

    chosen = {name: settings_for(found) for name, found in everyone.items()}
    stage("closings in full")
    acting: list[type[Policy]] = [baseline(), candidate(), baseline(True), candidate(True)]
    jobs = [
        RealJob(p, k.name, chosen[k.name](p.kind), *(FULL if k.has_reflex() else ("abrupt", None)))
        for k in acting
        for p in table.picks
    ]
    closings = runner.map(real, jobs, own)
    stage("controls")
    best = ceiling(table)
    between_of = {name: drops(found, weights) for name, found in everyone.items()}
    real_of = {
        k.name: _real([r for r in closings if r.job.policy == k.name], everyone[k.name], tables)
        for k in acting
    }
    success = {name: _success(found) for name, found in everyone.items()}
    success.update({name: found.success for name, found in real_of.items()})
    success["ceiling"] = 1 - float((best.dropped + best.damaged).min())
    dropped = {name: found.value for name, found in between_of.items()}
    dropped["ceiling"] = float(best.drops_at())
    fronts = {name: _points(found) for name, found in everyone.items()}
    fronts["ceiling"] = FrontPoints(dropped=best.dropped.tolist(), damaged=best.damaged.tolist())
    count = settings.permutations
    results = Household(
        objects=len(set(table.kinds)),
        hands=len(set(table.hands.tolist())),
        picks=len(table.picks),
        damage=DAMAGE,
        success=success,
        drops_at_10_damage=dropped,
        drops_between=between_of,
        fewer_drops_than_blind=fewer(ours, blind, weights),
        fewer_drops_as_bold=fewer_as_bold(ours, blind, weights),
        success_gain=_gain(closings, weights),
        fewer={n: fewer(f, blind, weights) for n, f in plain.items() if f is not blind},
        target=TARGET,
        controls={
            "mass_permuted": permuted(tables, count, True, False, seed),
            "damage_permuted": permuted(tables, count, False, True, seed),
            "both_permuted": permuted(tables, count, True, True, seed),
        },
        slip_reflex={n: _reflexes(b, s, weights) for n, (b, s) in reflexes.items()},
        sensitivity=sensitivity(tables),
        fronts=fronts,
        closings=real_of,
        estimates=estimates(tables, rows, ours, own),
        by_object=by_object(tables, rows, {baseline().name: blind, candidate().name: ours}),
        tuned={name: _chosen(found, fold_of) for name, found in everyone.items()},
        tuned_on=_on(tables.tuning, tables),
        judged_on=_on(table, tables),
    )
    return HouseholdWork(results, own, chosen)


def conditions_name(condition: tuple[str, float]) -> str:
    """What a lift and a detection latency are called together."""
    place = (list(LIFTS).index(condition[0]), DETECTION.index(condition[1]))
    return next(name for name, at in conditions().items() if at == place)


def _noise(rmse: float) -> str:
    return "label" if rmse == 0 else f"label_rmse_{rmse:g}"


def _success(found: Judged) -> float:
    its = found.outcomes
    return float(1 - np.maximum(its.dropped[TUNED], its.damaged[TUNED]).mean())


def _points(found: Judged) -> FrontPoints:
    its = found.front
    return FrontPoints(dropped=its.dropped.tolist(), damaged=its.damaged.tolist())


def _reflexes(blind: Judged, ours: Judged, weights: NDArray[np.float64]) -> Reflexes:
    return Reflexes(
        blind=drops(blind, weights),
        stiffness=drops(ours, weights),
        fewer=fewer(ours, blind, weights),
        success={"blind": _success(blind), "stiffness": _success(ours)},
    )


def _chosen(found: Judged, fold_of: Mapping[str, int]) -> list[ChosenSettings]:
    return [
        ChosenSettings(
            left_out=[kind for kind, its in fold_of.items() if its == fold],
            settings=one.settings, tried=one.tried, drops=one.drops, damage=one.damage,
        )
        for fold, one in enumerate(found.chosen)
    ]  # fmt: skip


def _on(table: Table, tables: Tables) -> TunedOn:
    return TunedOn(
        hands=sorted(set(table.hands.tolist())),
        specimens=sorted({pick.specimen for pick in table.picks}),
        picks=len(table.picks),
        budget=tables.budget,
        folds=tables.folds,
        families=[list(words) for words in FAMILIES],
    )


def _gain(rows: Sequence[RealRow], weights: NDArray[np.float64]) -> Between:
    """Of the same picks, in the table's order: how many more end well with stiffness."""
    fine = [
        np.array([not (r.dropped or r.damaged) for r in rows if r.job.policy == kind.name], float)
        for kind in (candidate(), baseline())
    ]
    apart = fine[0] - fine[1]
    return between(float(apart.mean()), apart @ weights / weights.sum(axis=0))


def _real(rows: Sequence[RealRow], found: Judged, tables: Tables) -> RealClosings:
    """Of a policy as tuned; picks in the table's order."""
    weights = weights_of(tables.judged, tables.seed)
    dropped = np.array([r.dropped for r in rows])
    damaged = np.array([r.damaged for r in rows])
    # What broke is not what was to be held: it counts once.
    dropped &= ~damaged
    fine = ~(dropped | damaged)
    its = found.outcomes
    alike = fine == (np.maximum(its.dropped[TUNED], its.damaged[TUNED]) < 1)
    deadline = POLICIES[rows[0].job.policy].deadline
    times = [1e3 * r.steady for r in rows if r.steady is not None]

    def share(flags: np.ndarray) -> Between:
        drawn = flags.astype(np.float64) @ weights / weights.sum(axis=0)
        return between(float(flags.mean()), drawn)

    return RealClosings(
        n=len(rows),
        success=float(fine.mean()),
        dropped=float(dropped.mean()),
        damaged=float(damaged.mean()),
        steady=len(times) / len(rows),
        steady_ms=float(np.mean(times)) if times else None,
        as_table=float(alike.mean()),
        in_time=None if deadline is None else float(np.mean([r.estimates > 0 for r in rows])),
        intervals={
            name: (b.low, b.high)
            for name, b in {
                "success": share(fine), "dropped": share(dropped), "damaged": share(damaged)
            }.items()
        },
    )  # fmt: skip
