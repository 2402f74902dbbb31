"""Run of the household part of the study: models of the hands, tables, tuning and judging."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from firstcontact.core import Runner
from firstcontact_lab.grasping._approach import Pick
from firstcontact_lab.grasping._branches import Branches, Branching, branches
from firstcontact_lab.grasping._findings import findings
from firstcontact_lab.grasping._full_closings import full_closings
from firstcontact_lab.grasping._household_numbers import Tables, resample_weights
from firstcontact_lab.grasping._judgement import SettingsOf, judgement
from firstcontact_lab.grasping._own_hand import HandSeed, OwnHand, own_hand
from firstcontact_lab.grasping._table import Table
from firstcontact_lab.grasping.results import Household
from firstcontact_lab.grasping.settings import HouseholdSettings

OwnHands = dict[tuple[int, float], OwnHand]


@dataclass(frozen=True, slots=True, eq=False)
class HouseholdWork:
    """Results of the household part, and what the film needs: models of hands, tuned settings."""

    results: Household
    hands: OwnHands
    chosen: Mapping[str, SettingsOf]


def household(
    settings: HouseholdSettings, seed: int, runner: Runner, stage: Callable[[str], object]
) -> HouseholdWork:
    """Run the household part of the study."""
    how = Branching(settings.speeds, settings.forces, settings.boosts)
    tuning_hands, judged_hands = settings.hand_seeds(seed)
    stage("own hands")
    hands = [HandSeed(h, v) for h in (*tuning_hands, *judged_hands) for v in how.speeds]
    made = runner.map(own_hand, hands, settings.blocks)
    hands_by_speed: OwnHands = {(h.seed, h.speed): o for h, o in zip(hands, made, strict=True)}

    def table(title: str, seeds: Sequence[int], specimens: Sequence[int]) -> list[Branches]:
        stage(title)
        picks = [Pick(k, h, s) for k in settings.kinds for h in seeds for s in specimens]
        return runner.map(
            branches, [(p, v) for p in picks for v in how.speeds], hands_by_speed, how
        )

    tuning = table("closings to tune on", tuning_hands, settings.tuning_specimens)
    rows = table("closings to judge", judged_hands, settings.judged_specimens)
    stage("tuning")
    tables = Tables(
        Table.from_branches(tuning, how),
        Table.from_branches(rows, how),
        settings.folds,
        settings.budget,
        settings.few,
        seed,
    )
    weights = resample_weights(tables.judged, seed)
    judged_policies = judgement(tables)
    stage("full closings")
    full = full_closings(judged_policies, tables.judged, weights, hands_by_speed, runner)
    stage("controls")
    results = findings(
        tables, rows, hands_by_speed, judged_policies, full, weights, settings.permutations
    )
    return HouseholdWork(results, hands_by_speed, judged_policies.chosen())
