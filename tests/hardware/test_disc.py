"""Finite elements of the glued disc and of the dimpled pad against closed forms."""

import math
from dataclasses import replace

import disc
import numpy as np
import pytest
from dimensions import NOMINAL
from disc import D33, PERMITTIVITY, PZT, Gluing, sensitivity
from pad import MODULUS, Pad
from stack import VACUUM, Layer, Stack, isotropic

from firstcontact.core.physics import POISSON
from firstcontact.twin import disc as twin_disc
from firstcontact.twin import pad as twin_pad
from firstcontact.twin.mechanics import FingerParameters

RADIUS = 5e-3
AREA = math.pi * RADIUS**2


def test_free_disc_has_the_exact_voltage_and_capacitance() -> None:
    free = Stack([Layer(0.2e-3, RADIUS, PZT)], is_smooth=True)
    capacitance = PERMITTIVITY * VACUUM * AREA / 0.2e-3
    assert free.capacitance() == pytest.approx(capacitance, rel=1e-6)
    assert free.volts_per_newton(0, RADIUS) == pytest.approx(D33 / capacitance, rel=1e-6)
    assert pytest.approx(capacitance) == disc.CAPACITANCE


def test_compressed_column_sinks_as_hooke_says() -> None:
    column = Stack([Layer(2e-3, RADIUS, isotropic(3e9, 0.4), 3)], is_smooth=True)
    for sinking in column.sinking(0, RADIUS):
        assert sinking == pytest.approx(2e-3 / (3e9 * AREA), rel=1e-6)


def test_laterally_held_layer_is_stiffer_by_poissons_ratio() -> None:
    # A thin layer on rigid ground cannot spread: modulus E (1 - n) / ((1 + n) (1 - 2 n)).
    held = Stack(
        [Layer(0.02e-3, RADIUS, isotropic(3e6, 0.4)), Layer(2e-3, RADIUS, isotropic(1e13, 0.0))]
    )
    modulus = 3e6 * 0.6 / (1.4 * 0.2)
    assert held.sinking(0, RADIUS)[0] == pytest.approx(0.02e-3 / (modulus * AREA), rel=0.01)


def test_plate_on_a_post_bends_as_plate_theory_says() -> None:
    # Clamped at r = b, 1 N on the rim at r = a. Deflection
    # w = A + B ln r + C r^2 + r^2 ln r / (8 pi D).
    a, b, thickness, poisson = 20e-3, 4e-3, 0.4e-3, 0.14
    rigidity = 22e9 * thickness**3 / (12 * (1 - poisson**2))
    k = 1 / (8 * math.pi * rigidity)
    log_a, log_b = math.log(a), math.log(b)
    equations = [
        [1, log_b, b**2],
        [0, 1 / b, 2 * b],
        [0, (poisson - 1) / a**2, 2 + 2 * poisson],
    ]
    particular = [
        k * b**2 * log_b,
        k * (2 * b * log_b + b),
        k * ((2 * log_a + 3) + poisson * (2 * log_a + 1)),
    ]
    A, B, C = np.linalg.solve(equations, -np.array(particular))
    expected = abs(A + B * log_a + C * a**2 + k * a**2 * log_a)
    plate = Stack([
        Layer(0.1e-3, b, isotropic(1e15, 0.0)), Layer(thickness, a, isotropic(22e9, poisson)),
    ])  # fmt: skip
    assert plate.sinking(a - 0.05e-3, a)[1] == pytest.approx(expected, rel=0.03)


def test_thin_disc_on_a_bent_plate_gives_the_voltage_of_d31() -> None:
    # Board on a ring, loaded from below on a smaller ring: equal bending in all directions inside.
    board, thin, outer, inner, modulus, poisson = 1.6e-3, 0.02e-3, 20e-3, 10e-3, 22e9, 0.14
    stack = Stack(
        [Layer(board, outer, isotropic(modulus, poisson), 4), Layer(thin, 3e-3, PZT)],
        held=(outer - 1e-6, outer),
        is_smooth=True,
    )
    ratio = inner / outer
    moment = (1 + poisson) * math.log(1 / ratio) + (1 - poisson) / 2 * (1 - ratio**2)
    moment *= 1 / (4 * math.pi)
    rigidity = modulus * board**3 / (12 * (1 - poisson**2))
    strain = moment / (rigidity * (1 + poisson)) * (board + thin) / 2
    # The disc without charge is stiffer than with its faces connected, and holds the face back.
    s11, s12, d31, free = 16.4e-12, -5.74e-12, -171e-12, PERMITTIVITY * VACUUM
    stiffness = 1 / (s11 + s12 - 2 * d31**2 / free)
    strain /= 1 + 4 * stiffness * thin * (1 - poisson) / (modulus * board)
    expected = -2 * d31 * stiffness * strain / free * thin
    volts = stack.volts_per_newton(inner - 0.3e-3, inner + 0.3e-3, is_below=True)
    assert abs(volts) == pytest.approx(abs(expected), rel=0.05)


def test_fingertip_in_silicone_answers_alike_everywhere() -> None:
    for name in list(disc.GLUINGS)[:3]:  # as drawn, and with glue at its tolerances
        found = sensitivity(disc.GLUINGS[name])
        assert min(found.centre, found.middle, found.corner) > 0
        assert found.spread < 0.15, name
        assert found.capacitance == pytest.approx(disc.CAPACITANCE, rel=0.01)


def test_epoxy_turns_the_sign_at_the_corners_and_lowers_the_capacitance() -> None:
    epoxy = sensitivity(disc.GLUINGS["epoxy on both faces"])
    assert epoxy.corner < -0.3 < 0 < 0.3 < epoxy.centre
    assert epoxy.capacitance < 0.87 * disc.CAPACITANCE
    at_board = sensitivity(disc.GLUINGS["epoxy at the board, silicone at the post"])
    assert at_board.corner < epoxy.corner


def test_result_does_not_depend_on_the_size_of_the_elements() -> None:
    fine = Gluing().stack(0.12e-3).volts_per_newton(6.4e-3, 8.9e-3)
    assert fine == pytest.approx(Gluing().stack().volts_per_newton(6.4e-3, 8.9e-3), rel=2e-3)


def test_twin_has_the_voltages_of_the_finite_elements() -> None:
    found = sensitivity()
    assert (
        pytest.approx([found.corner] * 2 + [found.middle] * 2 + [found.corner] * 2, rel=5e-3)
        == twin_disc.VOLTS_PER_NEWTON
    )
    nominal = FingerParameters().piezo_volts_per_newton
    assert nominal == pytest.approx(twin_disc.VOLTS_PER_NEWTON.mean(), rel=1e-3)
    stiff, soft = (sensitivity(disc.GLUINGS[name]) for name in list(disc.GLUINGS)[1:3])
    ratio = found.corner / found.middle
    assert (
        pytest.approx([g.corner / g.middle / ratio for g in (stiff, soft)], rel=5e-3)
        == twin_disc.CORNERS
    )


#: A small pad: elements of the same size, and few of them.
SMALL = replace(NOMINAL, board_length=12.0, board_width=9.0, draft=0.0)


@pytest.mark.parametrize("slides", [False, True])
def test_tall_thin_dimples_are_columns(slides: bool) -> None:
    tall = replace(SMALL, dimple_diameter=1.5, dimple_height=20.0)
    column = MODULUS * math.pi * (0.75e-3) ** 2 / 20e-3
    assert Pad(tall, layers=(4, 8), slides=slides).whole() == pytest.approx(6 * column, rel=0.07)


def test_touch_on_a_solid_layer_is_confined_by_its_back() -> None:
    # Dimples as large as the pad: a layer bonded to the board. A thin layer takes 0.1416 / (G h)
    # from the sinking of a half space: Dimitriadis et al. (2002), Biophys. J. 82, 2798.
    solid = replace(SMALL, dimple_diameter=40.0)
    shear, thickness = MODULUS / (2 * (1 + POISSON)), 3.8e-3
    expected = -0.1416 / (shear * thickness)
    assert 1 / Pad(solid).spring(radius=1.5e-3) == pytest.approx(expected, rel=0.15)


def test_pad_does_not_depend_on_the_size_of_the_elements() -> None:
    coarse, fine = (
        pad.sinking((0.0, 0.0), 2.5e-3) for pad in (Pad(SMALL), Pad(SMALL, 0.34e-3, (8, 3)))
    )
    assert fine == pytest.approx(coarse, rel=0.05)


def test_twin_has_the_pad_of_the_drawing() -> None:
    pads = [Pad(slides=slides) for slides in (False, True)]
    # The elements of this size are some 6 % too stiff.
    touched = math.prod(1 / float(np.mean(1 / pad.springs())) for pad in pads) ** 0.5
    assert twin_pad.PadParameters().stiffness == pytest.approx(touched, rel=0.12)
    whole = math.prod(pad.whole() for pad in pads) ** 0.5
    assert whole == pytest.approx(twin_pad.ON_DIMPLES, rel=0.15)
