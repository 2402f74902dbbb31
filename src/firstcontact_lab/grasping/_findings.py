"""Results of the household part, from judged policies and newly simulated full closings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from firstcontact_lab.grasping._branches import Branches
from firstcontact_lab.grasping._estimates import by_object, estimates
from firstcontact_lab.grasping._families import FAMILIES
from firstcontact_lab.grasping._front import DAMAGE, TUNED, Front
from firstcontact_lab.grasping._full_closings import FullClosings
from firstcontact_lab.grasping._household_numbers import (
    Judged,
    Tables,
    baseline,
    candidate,
    ceiling,
    drops,
    fewer,
    fewer_as_bold,
    permuted,
)
from firstcontact_lab.grasping._judgement import Judgement
from firstcontact_lab.grasping._own_hand import OwnHand
from firstcontact_lab.grasping._sensitivity import sensitivity
from firstcontact_lab.grasping._table import Table
from firstcontact_lab.grasping.results import (
    CEILING,
    Between,
    ChosenSettings,
    FrontPoints,
    Household,
    Reflexes,
    ReflexSuccess,
    TunedOn,
)

#: Target of the study: relative reduction in drops.
TARGET = 0.35


def findings(
    tables: Tables,
    rows: Sequence[Branches],
    hands: Mapping[tuple[int, float], OwnHand],
    judgement: Judgement,
    full: FullClosings,
    weights: NDArray[np.float64],
    permutations: int,
) -> Household:
    """Return all results of the household part."""
    table, blind, ours, everyone = (
        tables.judged,
        judgement.blind,
        judgement.ours,
        judgement.everyone,
    )
    best = ceiling(table)
    between_of = {name: drops(policy, weights) for name, policy in everyone.items()}
    return Household(
        objects=len(set(table.kinds)),
        hands=len(set(table.hands.tolist())),
        picks=len(table.picks),
        damage=DAMAGE,
        success=_successes(everyone, full, best),
        drops_at_10_damage={
            **{name: policy.value for name, policy in between_of.items()},
            CEILING: float(best.drop_share()),
        },
        drops_between=between_of,
        fewer_drops_than_blind=fewer(ours, blind, weights),
        fewer_drops_as_bold=fewer_as_bold(ours, blind, weights),
        success_gain=full.gain,
        fewer={n: fewer(f, blind, weights) for n, f in judgement.plain.items() if f is not blind},
        target=TARGET,
        controls=_controls(tables, permutations),
        slip_reflex={n: _reflexes(b, s, weights) for n, (b, s) in judgement.reflexes.items()},
        sensitivity=sensitivity(tables),
        fronts={
            **{name: _points(policy.front) for name, policy in everyone.items()},
            CEILING: _points(best),
        },
        closings=dict(full.by_policy),
        estimates=estimates(tables, rows, ours, hands),
        by_object=by_object(tables, rows, {baseline().name: blind, candidate().name: ours}),
        tuned={name: _chosen(policy, judgement.fold_of) for name, policy in everyone.items()},
        tuned_on=_on(tables.tuning, tables),
        judged_on=_on(table, tables),
    )


def _controls(tables: Tables, count: int) -> dict[str, Between]:
    return {
        "mass_permuted": permuted(tables, count, True, False, tables.seed),
        "damage_permuted": permuted(tables, count, False, True, tables.seed),
        "both_permuted": permuted(tables, count, True, True, tables.seed),
    }


def _successes(everyone: Mapping[str, Judged], full: FullClosings, best: Front) -> dict[str, float]:
    """Return for each tuned policy the share of picks that are neither dropped nor damaged."""
    return {
        **{name: _success(policy) for name, policy in everyone.items()},
        **{name: policy.success for name, policy in full.by_policy.items()},
        CEILING: 1 - float((best.dropped + best.damaged).min()),
    }


def _success(judgement: Judged) -> float:
    policy = judgement.outcomes
    return float(1 - np.maximum(policy.dropped[TUNED], policy.damaged[TUNED]).mean())


def _points(front: Front) -> FrontPoints:
    return FrontPoints(dropped=front.dropped.tolist(), damaged=front.damaged.tolist())


def _reflexes(blind: Judged, ours: Judged, weights: NDArray[np.float64]) -> Reflexes:
    return Reflexes(
        blind=drops(blind, weights),
        stiffness=drops(ours, weights),
        fewer=fewer(ours, blind, weights),
        success=ReflexSuccess(blind=_success(blind), stiffness=_success(ours)),
    )


def _chosen(judgement: Judged, fold_of: Mapping[str, int]) -> list[ChosenSettings]:
    return [
        ChosenSettings(
            left_out=[kind for kind, policy in fold_of.items() if policy == fold],
            settings=one.settings, tried=one.tried, drops=one.drops, damage=one.damage,
        )
        for fold, one in enumerate(judgement.chosen)
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
