"""Numbers from the table of closings: forces, fronts, resamples, tuning and comparison policies."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from toys import HOW, THINGS, branch, table

from firstcontact.grasp import POLICIES
from firstcontact.twin.household import HOUSEHOLD
from firstcontact_lab.grasping.judgement import (
    Tables,
    baseline,
    best_possible_front,
    candidate,
    drop_reduction,
    drop_share,
    judge_policy,
    noisy_labels,
    reduction_after_swaps,
    relative_reduction,
    resample_weights,
)
from firstcontact_lab.grasping.table import ClosingTable, ReflexIndices
from firstcontact_lab.grasping.tuning import (
    FAMILIES,
    assign_folds,
    bootstrap_weights,
    family_of,
    policy_settings,
)

TABLES = Tables(table((1, 2)), table((11, 12, 13)), 4, 64, True, 3)


@given(st.floats(1.0, 8.0))
def test_between_the_forces_of_the_table_it_is_a_straight_line(force: float) -> None:
    toy = table((1,))
    peak, hold = toy.interpolate_forces(0, np.full((2, len(THINGS)), force))
    assert peak == pytest.approx(np.full((2, len(THINGS)), force))
    assert hold == pytest.approx(2 * peak)
    results = toy.outcomes(0, np.full(len(THINGS), force))
    for place, pick in enumerate(toy.picks):
        holds, limit = THINGS[pick.kind]
        assert results.dropped[place] == (force < holds - 1e-12)
        assert results.damaged[place] == (force > limit)


def test_a_reflex_saves_what_slips_and_presses_harder_on_what_it_saves() -> None:
    toy = ClosingTable.from_branches([branch(kind, 1) for kind in THINGS], HOW)
    heavy = toy.with_properties(limit=np.full(len(THINGS), 8.5))
    forces = np.full(len(THINGS), 2.0)
    plain, reflex = heavy.outcomes(0, forces), heavy.outcomes(0, forces, ReflexIndices(1, 0, 0))
    assert plain.dropped.sum() == 4
    assert not plain.damaged.any()
    assert not reflex.dropped.any()
    assert (reflex.damaged == plain.dropped).all()


def test_resamples_draw_whole_kinds_within_groups_and_whole_hands() -> None:
    kinds = np.array(["a", "a", "b", "b", "c", "c"])
    hands = np.array([1, 2] * 3)
    groups = np.array(["x"] * 4 + ["y"] * 2)
    weights = bootstrap_weights(kinds, hands, groups, 200, 0)
    assert weights.shape == (6, 200)
    by_group = weights[:4].sum(axis=0), weights[4:].sum(axis=0)
    assert (by_group[0] == 4).all()
    assert (by_group[1] == 2).all()
    assert weights[0].std() > 0
    # What a kind and a hand count is multiplied.
    assert (weights[0] * weights[3] == weights[1] * weights[2]).all()


def test_families_are_left_out_whole_and_are_of_the_household() -> None:
    names = [entry.name for entry in HOUSEHOLD]
    for words in FAMILIES:
        for word in words:
            assert any(word in name for name in names), word
    fold_of = assign_folds(names, 6)
    assert set(fold_of.values()) == set(range(6))
    for one in names:
        for other in names:
            if family_of(one) == family_of(other):
                assert fold_of[one] == fold_of[other]


@pytest.mark.parametrize("name", ["blind", "stiffness", "weight"])
def test_every_policy_gets_the_same_number_of_settings_or_all(name: str) -> None:
    kind = POLICIES[name]
    every = np.prod([len(t.tried) for t in kind.tunables.values()])
    for budget in (8, 10**6):
        computed = policy_settings(kind, budget, False, 1)
        assert len({tuple(one.items()) for one in computed}) == len(computed) == min(budget, every)
        assert computed == policy_settings(kind, budget, False, 1)


def test_stiffness_gains_only_if_firm_objects_are_heavy() -> None:
    weights = resample_weights(TABLES.judged, 0)
    blind, ours = judge_policy(TABLES, baseline()), judge_policy(TABLES, candidate())
    assert drop_share(blind, weights).value == pytest.approx(0.5)
    assert drop_share(ours, weights).value == 0.0
    gain = drop_reduction(ours, blind, weights)
    assert gain.value == 1.0
    assert 0.0 < gain.low <= gain.high == 1.0
    predictions = noisy_labels(TABLES.tuning, 0.0, 0), noisy_labels(TABLES.judged, 0.0, 0)
    assert drop_share(judge_policy(TABLES, candidate(), predictions), weights).value == 0.0
    assert best_possible_front(TABLES.judged).drop_share() == 0.0
    assert reduction_after_swaps(TABLES, 12, True, True, 0).value < 0.5


def test_a_gain_is_a_share_of_what_the_other_drops_and_none_may_be_bought_for_nothing() -> None:
    dropped, remaining = np.array([0.1, 0.2, 0.9, 0.0, 0.1]), np.array([0.2, 0.1, 0.1, 0.0, 0.0])
    assert relative_reduction(dropped, remaining) == pytest.approx([0.5, -1.0, -1.0, 0.0, -1.0])


@given(st.integers(0, 10**6))
def test_nothing_in_the_table_is_better_than_the_ceiling(seed: int) -> None:
    rng = np.random.default_rng(seed)
    toy = table((1, 2))
    hard = toy.with_properties(
        toy.needed * np.exp(rng.normal(size=len(toy.picks))),
        toy.limit * np.exp(rng.normal(size=len(toy.picks))),
    )
    best = best_possible_front(hard)
    within = np.geomspace(HOW.forces[0], HOW.forces[-1], 60)
    for reflex in (None, ReflexIndices(1, 0, 0)):
        entry = hard.outcomes(0, rng.choice(within, size=(7, len(toy.picks))), reflex)
        lost = (entry.dropped + entry.damaged).mean(axis=1)
        assert (lost >= (best.dropped + best.damaged).min() - 1e-12).all()
        assert (entry.damaged.mean(axis=1) >= best.damaged.min()).all()


def test_nobody_is_tuned_on_the_family_that_it_is_judged_on() -> None:
    remaining = TABLES.tuning.limit.copy()
    remaining[TABLES.tuning.kinds == "quail egg"] = 0.01
    changed = replace(TABLES, tuning=TABLES.tuning.with_properties(limit=remaining))
    fold = assign_folds(sorted(set(TABLES.judged.kinds)), TABLES.folds)["quail egg"]
    original, current = (
        judge_policy(t, baseline()).chosen[fold].settings for t in (TABLES, changed)
    )
    assert original == current
