"""Statements of the grasping page agree with the committed results."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import write_tables as numbers
from pages import ROOT

from firstcontact.grasp import POLICIES
from firstcontact_lab.grasping._judgement import baseline, candidate
from firstcontact_lab.grasping._tuning import Front
from firstcontact_lab.grasping.page import HOUSEHOLD
from firstcontact_lab.grasping.results import FIRMEST, USED, Household
from firstcontact_lab.grasping.sentences import percent
from firstcontact_lab.report.findings import STUDY
from firstcontact_lab.report.results import SubjectResults
from firstcontact_lab.study.page import read_study

WORDS = (
    "none", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten"
)  # fmt: skip
BLIND, OURS = baseline().name, candidate().name


@cache
def results() -> SubjectResults:
    return read_study(numbers.RESULTS / "grasp.json").about


@cache
def household() -> Household:
    computed = results()[HOUSEHOLD]
    assert computed is not None
    return computed


@cache
def page() -> str:
    pages = ("explanation/grasping.md", "reference/lab-notes.md")
    text = " ".join((ROOT / "docs" / page).read_text(encoding="utf-8") for page in pages)
    return " ".join(text.replace("**", "").split())


def says(*sentences: str) -> None:
    for sentence in sentences:
        assert sentence in page(), sentence


def gain(name: str) -> int:
    return round(100 * household().fewer[name].value)


def test_sizes_and_seeds() -> None:
    on, judged = household().tuned_on, household().judged_on
    says(
        f"has {household().objects} objects from",
        f"{WORDS[len(on.hands)]} hands and {WORDS[len(on.specimens)]} specimen of each object. "
        f"They are scored on {WORDS[len(judged.hands)]} other hands and "
        f"{WORDS[len(judged.specimens)]} other specimens",
        f"are divided into {WORDS[on.folds]} folds",
        f"tries {on.budget} random settings of each policy",
        f"are of `--seed {results()[STUDY].seed}`",
    )
    assert household().objects == 34, "which the page writes in words, too"
    assert not set(on.hands) & set(judged.hands)


def test_the_gain_and_what_the_label_would_give() -> None:
    entry = household()
    label = entry.fewer["label"]
    says(
        f"The target was {percent(entry.target)} fewer drops with an interval that excludes zero. "
        f"The gain is {gain(OURS)} %",
        f"with the true label the rule gains {gain('label')} %, but the interval starts at "
        f"{100 * label.low:.0f}.".replace("-", "−"),
        f"With the tuned forces {percent(entry.closings[OURS].success)} of closings end without "
        f"drop or damage, instead of {percent(entry.closings[BLIND].success)}",
    )
    assert not entry.met
    noisy = [entry.fewer[f"label_rmse_{rmse}"] for rmse in (3, 5, 10)]
    assert all(n.low < label.value < n.high for n in noisy), "nothing that could be told"
    assert entry.drops_at_10_damage["weight"] < 0.005


def test_what_is_held_and_what_it_costs() -> None:
    entry = household().by_object
    held_out = ("mug, 0.2 l in it", "wood block", "hammer, at its handle", "sugar box")
    assert [entry[name].drops[BLIND] for name in held_out] == [1, 1, 1, 1]
    can = entry["soup can"]
    says(f"{WORDS[round(can.n * can.drops[BLIND])]} of {WORDS[can.n]} soup cans")
    assert not any(entry[name].drops[OURS] for name in (*held_out, "soup can"))
    assert entry["mustard bottle, full"].drops == {BLIND: 1, OURS: 1}
    assert entry["paper cup, 0.2 l in it"].drops[OURS] == 1
    assert entry["cracker"].damage[OURS] == 1
    egg, crushed, tomato = (
        entry[name].n * entry[name].damage[OURS]
        for name in ("quail egg", "blueberry", "ripe tomato")
    )
    berry, red = entry["blueberry"].bias, entry["ripe tomato"].bias
    assert berry is not None
    assert red is not None
    says(
        f"{WORDS[round(egg)]} of {WORDS[entry['quail egg'].n]} quail's eggs",
        f"estimates are {berry:.0f} and {red:.0f} Shore A too firm",
    )
    says(
        f"{WORDS[round(crushed)]} of {WORDS[entry['blueberry'].n]} blueberries",
        f"{WORDS[round(tomato)]} of {WORDS[entry['ripe tomato'].n]} tomatoes",
    )
    both = [n for n, o in entry.items() if o.fragile and o.shore_a > FIRMEST]
    says(f"and there are {WORDS[len(both)]} of them")
    assert len(both) == 3


def test_a_cautious_hand_gains_nothing() -> None:
    says(
        "If 6 % or less may be damaged, `blind` drops fewer objects. From 10 % on, `stiffness` does"
    )
    fronts = household().fronts
    ours, blind = (
        Front(np.array(fronts[n].dropped), np.array(fronts[n].damaged)) for n in (OURS, BLIND)
    )
    for damage in np.arange(0.03, 0.062, 0.005):
        assert blind.drop_share(damage) < ours.drop_share(damage)
    for damage in (0.1, 0.15, 0.2):
        assert blind.drop_share(damage) > ours.drop_share(damage)


def test_what_a_reflex_leaves() -> None:
    says(
        "holds everything, and nothing is left for stiffness",
        "stiffness prevents six or seven of ten",
    )
    by = household().slip_reflex
    quick = by["gradual, 100 ms"]
    assert quick.blind.value == quick.fewer.value == 0
    remaining = [r.fewer for r in by.values() if r is not quick]
    assert [f.value for f in remaining] == pytest.approx([0.65] * 3, abs=0.08)
    assert all(f.low < 0 for f in remaining)
    closed = household().closings
    for name, table in (
        (baseline(True).name, quick.success.blind),
        (candidate(True).name, quick.success.stiffness),
    ):
        assert table - closed[name].success == pytest.approx(0.02, abs=0.005)


def test_the_estimates_by_object() -> None:
    entry = {n: o for n, o in household().by_object.items() if o.shore_a <= FIRMEST}
    errors = {name: o.rmse[USED] for name, o in entry.items()}
    well = [name for name, e in errors.items() if e <= 5]
    nearly = {name: e for name, e in errors.items() if 5 < e < 10}
    says(
        f"Of the {len(entry)} objects up to {FIRMEST:g} Shore A, {len(well)} have an RMSE of 5 or "
        f"less, and {WORDS[len(nearly)]} more {max(nearly.values()):.1f} or less",
        f"blueberry (RMSE {errors['blueberry']:.0f})",
    )
    assert {*errors} - {*well, *nearly} == {"blueberry"}
    firm = {n: o for n, o in household().by_object.items() if o.shore_a > FIRMEST}
    read = {n: o.shore_a + o.bias for n, o in firm.items() if o.bias is not None}
    says(f"its mean prediction is {read.pop('potato crisp'):.0f}")
    labels = [o.shore_a for o in firm.values()]
    says(
        f"For objects of {min(labels):g} to {max(labels):g} Shore A the mean prediction is "
        f"{min(read.values()):.0f} to {max(read.values()):.0f}"
    )


def test_all_policies_are_named() -> None:
    assert all(f"`{name}`" in page() for name in POLICIES)
