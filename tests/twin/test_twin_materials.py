from __future__ import annotations

import math

import pytest

from firstcontact.twin.materials import (
    gent_modulus,
    hertz_impact,
    hertz_stiffness,
    loglinear_modulus,
    plane_strain_modulus,
)
from firstcontact.twin.mechanics import contact_stiffness
from firstcontact.twin.parameters import FingerParameters, ObjectParameters


@pytest.mark.parametrize(
    ("shore_a", "megapascal"),
    [(10, 0.4127), (20, 0.7319), (43, 1.8913), (60, 3.6051), (65, 4.4260)],
)
def test_gent_gives_the_values_of_its_formula(shore_a: float, megapascal: float) -> None:
    assert gent_modulus(shore_a) == pytest.approx(megapascal * 1e6, rel=2e-4)


def test_the_pad_is_65_shore_a() -> None:
    assert FingerParameters().pad_modulus == pytest.approx(gent_modulus(65), rel=2e-3)


def test_the_two_published_fits_differ_by_tens_of_per_cent() -> None:
    # This is how well a Shore reading fixes a modulus: the scatter of the objects is no more.
    for shore_a in (10, 20, 29, 43, 60):
        assert abs(math.log(gent_modulus(shore_a) / loglinear_modulus(shore_a))) < 0.7
    assert loglinear_modulus(30) == pytest.approx(1.16e6, rel=0.01)


def test_the_kernel_and_the_closed_form_share_one_contact_stiffness() -> None:
    p = FingerParameters()
    o = ObjectParameters(modulus=2e6, radius=0.035)
    radius = 1 / (1 / p.tip_radius + 1 / o.radius)
    expected = hertz_stiffness(plane_strain_modulus(p.pad_modulus, o.modulus), radius)
    assert contact_stiffness(p, o) == pytest.approx(expected, rel=1e-12)


def test_an_elastic_impact_turns_all_motion_into_indentation() -> None:
    depth, force, _ = hertz_impact(0.01, 0.2, 1e6, 0.01)
    stored = 2 / 5 * hertz_stiffness(1e6, 0.01) * depth**2.5
    assert stored == pytest.approx(0.5 * 0.01 * 0.2**2, rel=1e-12)
    assert force == pytest.approx(hertz_stiffness(1e6, 0.01) * depth**1.5)
