"""Moments after a contact at which models predict."""

from __future__ import annotations

from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.models import Touches


def test_moments_are_whole_milliseconds_from_2_to_15() -> None:
    assert Touches.moments(1000.0) == tuple(range(2, 16))
    assert Touches.moments(FINGERTIP_RATE)[0] == 10
    assert Touches.moments(FINGERTIP_RATE)[-1] == 74
