"""Tests that the page of parameters lists all of them with the code's values."""

import re
from dataclasses import fields
from pathlib import Path

import pytest
from pinches import EVERYDAY, PAPER_RIG

from firstcontact.core import physics as physics
from firstcontact.twin import _run as run
from firstcontact.twin import _stream as stream
from firstcontact.twin import draw as draw
from firstcontact.twin import noise as noise
from firstcontact.twin import objects as objects
from firstcontact.twin import outcome as outcome
from firstcontact.twin import pinch as pinch
from firstcontact.twin import plant as plant
from firstcontact.twin import sensor as sensor
from firstcontact.twin import simulation as sets
from firstcontact.twin.draw import Condition, Spread
from firstcontact.twin.drive import Drive
from firstcontact.twin.mechanics import FingerParameters, ObjectParameters, VelostatParameters
from firstcontact.twin.noise import MotorNoise
from firstcontact.twin.slip_sound import SlipParameters

PAGE = Path(__file__).parents[2] / "docs/reference/twin-parameters.md"
NOMINAL: dict[str, dict[str, float]] = {
    "FingerParameters": FingerParameters()._asdict(),
    "ObjectParameters": ObjectParameters()._asdict(),
    "VelostatParameters": VelostatParameters()._asdict(),
    "SlipParameters": SlipParameters()._asdict(),
    "MotorNoise": {f.name: getattr(MotorNoise(), f.name) for f in fields(MotorNoise)},
}
#: Modules of the constants that each section of the page lists.
MODULES = {
    "## Constants": (draw, pinch, run, noise, sensor, physics, sets),
    "## The running hand": (stream,),
    "### Held objects": (objects, physics, outcome, plant, run),
}


def rows(section: str, mark: str = "##") -> dict[str, list[str]]:
    """Return the cells of each row of a section's table, by the first cell."""
    text = PAGE.read_text(encoding="utf-8").split(f"\n{mark} {section}\n")[1]
    text = re.split(r"\n##+ ", text)[0]
    lines = [line.strip("|").split("|") for line in text.splitlines() if line.startswith("| ")]
    lines = [cells for cells in lines if cells[0] != " --- "]
    return {cells[0].strip().strip("`"): [c.strip() for c in cells[1:]] for cells in lines[1:]}


@pytest.mark.parametrize("kind", NOMINAL)
def test_page_lists_every_parameter_with_value_and_source(kind: str) -> None:
    table = rows(kind)
    assert list(table) == list(NOMINAL[kind])
    for field, value in NOMINAL[kind].items():
        assert float(table[field][0]) == value, field
        assert table[field][1], f"{field}: from where?"


def test_the_pad_is_65_shore_a() -> None:
    assert FingerParameters().pad_modulus == pytest.approx(physics.gent_modulus(65), rel=2e-3)


def condition_numbers(value: object) -> list[float]:
    if isinstance(value, Spread):
        return [value.session, value.pinch]
    if isinstance(value, tuple):
        return list(value)
    assert isinstance(value, int | float)
    return [float(value)]


def test_page_lists_both_conditions() -> None:
    table = rows("Conditions")
    assert list(table) == [f.name for f in fields(Condition) if f.name != "name"]
    for field, cells in table.items():
        for cell, condition in zip(cells[:2], (PAPER_RIG, EVERYDAY), strict=True):
            numbers = [float(n) for n in re.split(" / |, ", cell)]
            assert numbers == condition_numbers(getattr(condition, field)), (
                f"{condition.name}: {field}"
            )


def constant(name: str, modules: tuple[object, ...]) -> list[float]:
    """Return the value of a constant, or both ends of a range, in the first module that has it."""
    value = next(getattr(module, name) for module in modules if hasattr(module, name))
    return [float(v) for v in (value if isinstance(value, tuple) else (value,))]


@pytest.mark.parametrize("section", MODULES)
def test_page_lists_the_constants(section: str) -> None:
    mark, title = section.split(" ", 1)
    table = rows(title, mark)
    assert len(table) >= 9
    for name, (value, meaning) in table.items():
        assert [float(v) for v in value.split(", ")] == constant(name, MODULES[section]), name
        assert meaning, f"{name}: from where?"


def test_page_lists_the_drive() -> None:
    table = rows("Drive", "###")
    assert {name: float(cells[0]) for name, cells in table.items()} == {
        f.name: getattr(Drive(), f.name) for f in fields(Drive)
    }
    assert Drive().force == FingerParameters().drive_force


@pytest.mark.parametrize(
    "kind", [FingerParameters, ObjectParameters, VelostatParameters, SlipParameters]
)
def test_structs_in_c_have_the_fields_of_the_named_tuples(kind: type[FingerParameters]) -> None:
    header = Path(draw.__file__).with_name("c") / "twin.h"
    body = header.read_text(encoding="utf-8").split(f"}} {kind.__name__};")[0].rpartition("{")[2]
    assert re.findall(r"\w+", body) == ["double", *kind._fields]
