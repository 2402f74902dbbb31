"""The page of household objects agrees with its data files."""

import write_household as script
from pages import ROOT

from firstcontact.twin.household import ESTIMATE, HOLD, HOUSEHOLD, LIGHT, LOOSE_HOLD, SCATTER
from firstcontact_lab.grasping.judgement import FRICTIONS, LIMITS, MASSES


def test_every_number_has_a_listed_source() -> None:
    used = {
        quantity.source
        for item in HOUSEHOLD
        for name in script.SHOWN
        if (quantity := getattr(item.numbers, name)) is not None
    }
    assert used - {ESTIMATE} == {source["key"] for source in script.SOURCES}


def test_its_scatters_and_variations_are_those_of_the_code() -> None:
    text = (ROOT / "docs/reference/twin-parameters.md").read_text(encoding="utf-8")
    for origin, scatter in SCATTER.items():
        numbers = (scatter.modulus, scatter.mass, scatter.friction)
        assert f"| {origin} | " + " | ".join(f"{n:g}" for n in numbers) + " |" in text
    for name, factors in (("limits", LIMITS), ("masses", MASSES), ("frictions", FRICTIONS)):
        for factor in factors:
            assert f"`{name} × {factor:g}`" in text
    held_out = f"{LOOSE_HOLD[0]:g} N/m and {LOOSE_HOLD[1]:g} N s/m below {1e3 * LIGHT:g} g"
    assert held_out in text
    assert f"{HOLD[0]:g} N/m and {HOLD[1]:g} N s/m" in text
