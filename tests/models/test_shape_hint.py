"""Shape hints of the user."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import InputError
from firstcontact.models.touches import LEAST, MOST, parse_radius, radius_text


@given(st.floats(LEAST, MOST))
def test_a_radius_in_mm_is_one_in_m(mm: float) -> None:
    assert parse_radius(f" {mm!r} mm ") == pytest.approx(mm / 1000)
    assert parse_radius(
        radius_text(parse_radius(str(mm))).removeprefix("radius ")
    ) == pytest.approx(mm / 1000, rel=1e-4)


def test_flat_and_nothing() -> None:
    assert parse_radius(" Flat") == math.inf
    assert radius_text(math.inf) == "flat"
    assert math.isnan(parse_radius(""))
    assert radius_text(None) == radius_text(math.nan) == ""


@pytest.mark.parametrize("text", ["round", "-3", "nan", "inf", "1e9", "4.9", "201", "37 cm"])
def test_what_is_no_shape_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="5 to 200 mm"):
        parse_radius(text)
