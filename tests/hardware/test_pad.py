"""Finite elements of the dimpled pad against closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from dimensions import NOMINAL
from pad import MODULUS, Pad

from firstcontact.core.physics import POISSON
from firstcontact.twin import pad as twin_pad

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


def test_result_does_not_depend_on_the_size_of_the_elements() -> None:
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
