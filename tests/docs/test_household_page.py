"""The page of household objects agrees with its data files."""

from __future__ import annotations

from pages import ROOT

from firstcontact.twin.household import HOLD, LIGHT, LOOSE_HOLD, SCATTER
from firstcontact_lab.grasping._judgement import FRICTIONS, LIMITS, MASSES


def test_its_scatters_and_variations_are_those_of_the_code() -> None:
    text = (ROOT / "docs/reference/household.md").read_text(encoding="utf-8")
    for origin, scatter in SCATTER.items():
        numbers = (scatter.modulus, scatter.mass, scatter.friction)
        assert f"| {origin} | " + " | ".join(f"{n:g}" for n in numbers) + " |" in text
    for name, factors in (("limits", LIMITS), ("masses", MASSES), ("frictions", FRICTIONS)):
        for factor in factors:
            assert f"`{name} × {factor:g}`" in text
    held_out = f"{LOOSE_HOLD[0]:g} N/m and {LOOSE_HOLD[1]:g} N s/m below {1e3 * LIGHT:g} g"
    assert held_out in text
    assert f"{HOLD[0]:g} N/m and {HOLD[1]:g} N s/m" in text
