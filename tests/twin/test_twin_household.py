"""Tests of the household's table and of the scatter of specimens."""

from __future__ import annotations

import csv
from dataclasses import replace
from importlib.resources import files
from io import StringIO

import numpy as np
import pytest

from firstcontact.core import InputError, gent_modulus
from firstcontact.twin import (
    BLOCKS,
    BRITTLE,
    EVERYDAY_OBJECTS,
    HOUSEHOLD,
    HOUSEHOLD_SOURCES,
    PAPER_RIG,
    QUANTITIES,
    draw_household_specimen,
    household_named,
)
from firstcontact.twin._household_file import RANGES, read_household, read_sources
from firstcontact.twin._household_object import SCATTER

TEXT = files("firstcontact.twin").joinpath("household.csv").read_text(encoding="utf-8")
SOURCES = files("firstcontact.twin").joinpath("household_sources.csv").read_text(encoding="utf-8")


def changed(line: int, **cells: str) -> str:
    rows = list(csv.DictReader(StringIO(TEXT)))
    rows[line].update(cells)
    out = StringIO()
    writer = csv.DictWriter(out, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()


def test_household_has_unique_names_in_four_groups() -> None:
    assert len(HOUSEHOLD) >= 34
    names = [item.name for item in HOUSEHOLD]
    assert len(set(names)) == len(names)
    assert "raspberry" in names
    assert any("hammer" in name for name in names)
    assert {item.group for item in HOUSEHOLD} == {
        "soft fragile", "soft robust", "firm fragile", "firm robust",
    }  # fmt: skip
    paper = {kind.name for kind in (*BLOCKS, *EVERYDAY_OBJECTS, *BRITTLE)}
    assert not paper & set(names), "a name means one thing"
    assert household_named("raspberry") is HOUSEHOLD[0]
    with pytest.raises(InputError, match="'anvil'"):
        household_named("anvil")


def test_every_number_has_a_listed_source() -> None:
    used = set()
    for item in HOUSEHOLD:
        for name in QUANTITIES:
            quantity = getattr(item.numbers, name)
            if quantity is not None:
                assert quantity.estimated or quantity.source in HOUSEHOLD_SOURCES
                used.add(quantity.source)
    assert used - {"estimate"} == set(HOUSEHOLD_SOURCES), "a source that nothing is from"


@pytest.mark.parametrize("item", HOUSEHOLD, ids=lambda t: t.name)
def test_twin_objects_have_the_values_of_the_table(item: object) -> None:
    item = household_named(item.name)
    kind, numbers = item.kind, item.numbers
    assert kind.shore_a == numbers.shore_a.value
    assert kind.mass == pytest.approx(numbers.mass.value)
    assert kind.nominal.modulus == gent_modulus(numbers.shore_a.value)
    assert kind.nominal.bulk_stiffness > 0
    assert (kind.fragility is None) == ("robust" in item.group)


@pytest.mark.parametrize(
    ("cells", "word"),
    [
        ({"name": ""}, "name is empty"),
        ({"name": "raspberry"}, "another object has the name 'raspberry'"),
        ({"origin": "found"}, "origin is 'found'"),
        (
            {"group": "firm fragile"},
            "the group is 'firm fragile', but the object's numbers fit 'soft fragile'",
        ),
        ({"mass": "5"}, "mass is '5': use a number from 0.0001 to 2"),
        ({"mass": "five grams"}, "mass is 'five grams'"),
        ({"mass": "nan"}, "mass is 'nan'"),
        ({"radius": "10"}, "radius is '10'"),
        ({"mass": "", "mass_from": ""}, "mass is empty"),
        ({"mass_from": ""}, "the source of mass is ''"),
        ({"mass_from": "hearsay"}, "the source of mass is 'hearsay'"),
        ({"limit": "", "limit_from": ""}, "limit and weibull belong together"),
        ({"limit": ""}, "limit has a source but no value"),
        ({"bulk": "", "bulk_from": "", "radius": "", "radius_from": ""}, "bulk and radius are"),
    ],
)
def test_invalid_rows_are_refused(cells: dict[str, str], word: str) -> None:
    with pytest.raises(InputError) as caught:
        read_household(changed(1, **cells), HOUSEHOLD_SOURCES, "here.csv")
    assert str(caught.value).startswith(f"here.csv, line 3: {word}")


def test_table_with_other_columns_is_refused() -> None:
    for text in ("", TEXT.replace("shore_a,", "shore,", 1), TEXT + "raspberry,soft fragile\n"):
        with pytest.raises(InputError, match=r"columns|cells"):
            read_household(text, HOUSEHOLD_SOURCES, "here.csv")


@pytest.mark.parametrize(
    ("row", "word"),
    [
        ("ycb,a,2000,b,c", "has the key"),
        ("estimate,a,2000,b,c", "has the key"),
        ("new,a,two thousand,b,c", "the year is"),
        ("new,a,20015,b,c", "the year is"),
        ("new,,2000,b,c", "is empty"),
    ],
)
def test_invalid_sources_are_refused(row: str, word: str) -> None:
    with pytest.raises(InputError, match=word):
        read_sources(f"{SOURCES}{row}\n", "here.csv")


def test_specimens_have_the_scatter_of_their_origin() -> None:
    item = household_named("raspberry")
    specimens = [draw_household_specimen(3, PAPER_RIG, item, n) for n in range(400)]
    assert specimens[7] == draw_household_specimen(3, PAPER_RIG, item, 7)
    scatter = SCATTER[item.origin]
    masses = np.log([specimen.mass / item.kind.mass for specimen in specimens])
    moduli = np.log(
        [specimen.nominal.modulus / item.kind.nominal.modulus for specimen in specimens]
    )
    frictions = np.array([specimen.friction for specimen in specimens]) - item.kind.friction
    for values, expected in (
        (masses, scatter.mass), (moduli, scatter.modulus), (frictions, scatter.friction)
    ):  # fmt: skip
        assert values.std() == pytest.approx(expected, rel=0.15)
        assert abs(values.mean()) < 0.2 * expected
    assert item.numbers.limit is not None
    limits = np.array([specimen.fragility.scale for specimen in specimens])
    below = (limits < item.numbers.limit.value).mean()
    assert below == pytest.approx(1 - np.exp(-1), abs=0.06)
    # A specimen bears the same each time.
    rng = np.random.default_rng(0)
    assert {specimens[0].fragility.draw(rng) for _ in range(5)} == {limits[0]}


def test_every_quantity_has_a_range() -> None:
    assert tuple(RANGES) == QUANTITIES
    assert all(low < high for low, high in RANGES.values())
    heavy = replace(HOUSEHOLD[0].numbers.mass, value=1.0)
    assert heavy.estimated == HOUSEHOLD[0].numbers.mass.estimated
