"""Impossible closing speeds are refused by constructors and by readers."""

from __future__ import annotations

import math

import pytest

from firstcontact.core import FASTEST, SLOWEST, ClosingSpeed, InputError


@pytest.mark.parametrize("speed", [0.0, -0.1, SLOWEST / 2, 2 * FASTEST, math.inf, math.nan])
def test_a_speed_out_of_range_is_refused(speed: float) -> None:
    with pytest.raises(InputError) as raised:
        ClosingSpeed(speed, 0.0)
    assert raised.value.parameter == "speed"


@pytest.mark.parametrize("error", [-1.0, 2 * FASTEST, math.inf, math.nan])
def test_an_error_out_of_range_is_refused(error: float) -> None:
    with pytest.raises(InputError) as raised:
        ClosingSpeed(0.1, error)
    assert raised.value.parameter == "error"


@pytest.mark.parametrize("speed", [SLOWEST, FASTEST])
def test_the_limits_are_speeds(speed: float) -> None:
    assert ClosingSpeed(speed, FASTEST).speed == speed
