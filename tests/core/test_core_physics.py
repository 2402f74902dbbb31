import pytest

from firstcontact.core.physics import POISSON, contact_modulus, gent_modulus, hertz_stiffness


@pytest.mark.parametrize(
    ("shore_a", "megapascal"),
    [(10, 0.4127), (20, 0.7319), (43, 1.8913), (60, 3.6051), (65, 4.4260)],
)
def test_gent_gives_the_values_of_its_formula(shore_a, megapascal):
    assert gent_modulus(shore_a) == pytest.approx(megapascal * 1e6, rel=2e-4)


@pytest.mark.parametrize("poisson", [0.3, POISSON, 0.5])
def test_against_a_rigid_body_only_the_softer_one_gives(poisson):
    alone = contact_modulus(1e6, 1e15, poisson)
    assert alone == pytest.approx(1e6 / (1 - poisson**2), rel=1e-6)
    assert contact_modulus(1e6, 1e6, poisson) == pytest.approx(alone / 2, rel=1e-6)


def test_hertz_stiffness_grows_with_the_modulus_and_the_root_of_the_radius():
    assert hertz_stiffness(3e6, 0.04) == pytest.approx(4 / 3 * 3e6 * 0.2)
