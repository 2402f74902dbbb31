"""Twin held to the continuum model, so that its physics cannot drift unseen."""

import numpy as np
import pytest

from firstcontact.twin.mechanics import FingerParameters
from firstcontact.twin.objects import OBJECTS
from firstcontact_lab.continuum.comparison import compare, object_body

SOLID = ("block 10", "block 29", "block 60", "apple 1", "orange 1", "avocado 1")


def test_body_of_an_object_has_its_mass_and_size() -> None:
    block = object_body(OBJECTS["block 29"])
    assert block.nodes[:, 1].max() == pytest.approx(0.035)
    assert block.nodes[:, 0].max() == pytest.approx(0.07 / np.sqrt(np.pi))
    for name in ("block 29", "apple 1", "tennis ball 1"):
        assert object_body(OBJECTS[name]).masses.sum() == pytest.approx(
            OBJECTS[name].mass, rel=0.015
        )


@pytest.mark.parametrize("is_rigid", [False, True], ids=["pad on dimples", "rigid tip"])
@pytest.mark.parametrize("name", SOLID)
def test_twin_touches_as_the_continuum(name: str, is_rigid: bool) -> None:
    found = compare(OBJECTS[name], FingerParameters(), is_rigid=is_rigid)
    assert abs(found.peak) < 0.05
    assert found.rms < 0.05


def test_twin_touches_a_hollow_ball_as_the_continuum() -> None:
    found = compare(OBJECTS["tennis ball 1"], FingerParameters())
    assert abs(found.peak) < 0.1
    assert found.rms < 0.1
