"""Tests of the household's table and of the scatter of specimens."""

import numpy as np
import pytest

from firstcontact.core import InputError
from firstcontact.core.physics import gent_modulus
from firstcontact.twin import BLOCKS
from firstcontact.twin.draw import condition
from firstcontact.twin.household import (
    HOUSEHOLD,
    SCATTER,
    HouseholdObject,
    draw_household_specimen,
    household_named,
)
from firstcontact.twin.objects import EVERYDAY_OBJECTS

#: Smallest and largest value of each quantity, in SI units and Shore A. A value outside probably
#: has another unit.
RANGES = {
    "shore_a": (1.0, 98.0),
    "mass": (1e-4, 2.0),
    "friction": (0.05, 1.5),
    "limit": (0.1, 100.0),
    "weibull": (1.0, 50.0),
    "radius": (1e-3, 0.2),
    "thickness": (1e-4, 0.2),
    "bulk": (100.0, 1e7),
    "loss": (0.0, 1.0),
}


def test_household_has_unique_names_in_four_groups() -> None:
    assert len(HOUSEHOLD) >= 34
    names = [item.name for item in HOUSEHOLD]
    assert len(set(names)) == len(names)
    assert "raspberry" in names
    assert any("hammer" in name for name in names)
    assert {item.group for item in HOUSEHOLD} == {
        "soft fragile", "soft robust", "firm fragile", "firm robust",
    }  # fmt: skip
    paper = {kind.name for kind in (*BLOCKS, *EVERYDAY_OBJECTS)}
    assert not paper & set(names), "a name means one thing"
    assert household_named("raspberry") is HOUSEHOLD[0]
    with pytest.raises(InputError, match="'anvil'"):
        household_named("anvil")


def test_specimens_have_the_scatter_of_their_origin() -> None:
    item = household_named("raspberry")
    specimens = [draw_household_specimen(3, condition("paper-rig"), item, n) for n in range(400)]
    assert specimens[7] == draw_household_specimen(3, condition("paper-rig"), item, 7)
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
    limits = np.array([specimen.fragility.scale for specimen in specimens])
    below = (limits < item.numbers.limit.value).mean()
    assert below == pytest.approx(1 - np.exp(-1), abs=0.06)
    # A specimen bears the same each time.
    rng = np.random.default_rng(0)
    assert {specimens[0].fragility.draw(rng) for _ in range(5)} == {limits[0]}


@pytest.mark.parametrize("item", HOUSEHOLD, ids=lambda t: t.name)
def test_numbers_are_in_range_and_fit_the_group(item: HouseholdObject) -> None:
    kind, n = item.kind, item.numbers
    assert kind.shore_a == n.shore_a.value
    assert kind.mass == pytest.approx(n.mass.value)
    assert kind.nominal.modulus == gent_modulus(n.shore_a.value)
    assert kind.nominal.bulk_stiffness > 0
    assert (kind.fragility is None) == (n.limit is None)
    for name, (low, high) in RANGES.items():
        quantity = getattr(n, name)
        if quantity is None:
            assert name in ("limit", "weibull", "radius", "bulk")
        else:
            assert low <= quantity.value <= high
    assert (n.limit is None) == (n.weibull is None)
    assert n.bulk is not None or n.radius is not None
    assert item.origin in SCATTER
    hardness = "soft" if n.shore_a.value < 45 else "firm"
    assert item.group == f"{hardness} {'robust' if n.limit is None else 'fragile'}"
