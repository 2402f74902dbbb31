"""Numbers in the text about grasping: if the results change, change them in the pages, too."""

import numpy as np
import pytest
import write_tables as numbers
from pages import ROOT

from firstcontact.grasp import POLICIES
from firstcontact_lab.grasping.judgement import baseline, candidate
from firstcontact_lab.grasping.page import HOUSEHOLD
from firstcontact_lab.grasping.results import FIRMEST, USED, Household
from firstcontact_lab.grasping.tuning import Front
from firstcontact_lab.report.findings import STUDY
from firstcontact_lab.study.page import read_study

BLIND, OURS = baseline().name, candidate().name
RESULTS = read_study(numbers.RESULTS / "grasp.json").about


@pytest.fixture(scope="module")
def household() -> Household:
    computed = RESULTS[HOUSEHOLD]
    assert computed is not None
    return computed


def percent(share: float) -> int:
    return round(100 * share)


def test_sizes_and_seeds(household: Household) -> None:
    on, judged = household.tuned_on, household.judged_on
    sizes = len(on.hands), len(on.specimens), len(judged.hands), len(judged.specimens)
    assert (household.objects, sizes, on.folds, on.budget) == (34, (3, 1, 4, 2), 6, 512)
    assert RESULTS[STUDY].seed == 1
    assert not set(on.hands) & set(judged.hands)


def test_gain(household: Household) -> None:
    fewer, closings, label = household.fewer, household.closings, household.fewer["label"]
    assert (percent(household.target), household.met) == (35, False)
    assert [percent(v) for v in (fewer[OURS].value, label.value, label.low)] == [65, 65, 3]
    assert [percent(closings[name].success) for name in (OURS, BLIND)] == [84, 75]
    noisy = [fewer[f"label_rmse_{rmse}"] for rmse in (3, 5, 10)]
    assert all(n.low < label.value < n.high for n in noisy), "nothing that could be told"
    assert household.drops_at_10_damage["weight"] < 0.005


def test_what_is_held_and_what_it_costs(household: Household) -> None:
    by_object = household.by_object
    held = ("mug, 0.2 l in it", "wood block", "hammer, at its handle", "sugar box")
    assert [by_object[name].drops[BLIND] for name in held] == [1, 1, 1, 1]
    can = by_object["soup can"]
    assert (can.n * can.drops[BLIND], can.n) == pytest.approx((7, 8))
    assert not any(by_object[name].drops[OURS] for name in (*held, "soup can"))
    mustard = by_object["mustard bottle, full"]
    assert min(mustard.drops[BLIND], mustard.drops[OURS]) > 0.8
    cup = by_object["paper cup, 0.2 l in it"]
    assert round(cup.n * cup.drops[OURS]) == 3
    damaged = [by_object[n] for n in ("cracker", "quail egg", "blueberry", "raspberry")]
    assert [round(o.n * o.damage[OURS]) for o in damaged] == [7, 3, 6, 4]
    assert [round(o.bias or 0.0) for o in damaged[2:]] == [34, 12]
    assert len([o for o in by_object.values() if o.fragile and o.shore_a > FIRMEST]) == 3


def test_a_cautious_hand_gains_nothing(household: Household) -> None:
    fronts = household.fronts
    ours, blind = (
        Front(np.array(fronts[n].dropped), np.array(fronts[n].damaged)) for n in (OURS, BLIND)
    )
    for damage in np.arange(0.03, 0.062, 0.005):
        assert blind.drop_share(damage) < ours.drop_share(damage)
    for damage in (0.1, 0.15, 0.2):
        assert blind.drop_share(damage) > ours.drop_share(damage)


def test_what_a_reflex_leaves(household: Household) -> None:
    quick = household.slip_reflex["gradual, 100 ms"]
    assert (quick.blind.value, percent(quick.stiffness.value)) == (0, 0)
    abrupt = household.slip_reflex["abrupt, 100 ms"].fewer
    remaining = [r.fewer for name, r in household.slip_reflex.items() if "300" in name]
    assert abrupt.value < 0
    assert sorted(percent(f.value) for f in remaining) == [27, 37]
    assert all(f.low < 0 for f in remaining)
    for name, table in (
        (baseline(True).name, quick.success.blind),
        (candidate(True).name, quick.success.stiffness),
    ):
        assert abs(table - household.closings[name].success) < 0.026


def test_estimates_by_object(household: Household) -> None:
    objects = household.by_object.items()
    errors = {name: o.rmse[USED] for name, o in objects if o.shore_a <= FIRMEST}
    nearly, small = (sum(e < most for e in errors.values()) for most in (10, 5))
    assert (len(errors), small, nearly) == (21, 3, 6)
    biases = [round(o.bias or 0.0) for n, o in objects if errors.get(n, 0.0) >= 10]
    assert (min(biases), max(biases)) == (9, 34)
    firm = {n: o for n, o in objects if o.shore_a > FIRMEST}
    read = {n: round(o.shore_a + o.bias) for n, o in firm.items() if o.bias is not None}
    crisp = household.by_object["potato crisp"]
    assert (crisp.answered, read.pop("potato crisp")) == (1, 48)
    labels = [o.shore_a for o in firm.values()]
    assert (min(labels), max(labels), min(read.values()), max(read.values())) == (85, 95, 65, 74)


def test_all_policies_are_named() -> None:
    pages = ("docs/explanation/grasping.md", "docs/reference/lab-notes.md")
    text = "".join((ROOT / page).read_text(encoding="utf-8") for page in pages)
    assert all(f"`{name}`" in text for name in POLICIES)
