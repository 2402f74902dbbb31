"""Moments after a contact at which models predict."""

from __future__ import annotations

from firstcontact.core import FINGERTIP_RATE
from firstcontact.models import moments


def test_moments_are_whole_milliseconds_from_2_to_15() -> None:
    assert moments(1000.0) == tuple(range(2, 16))
    assert moments(FINGERTIP_RATE)[0] == 10
    assert moments(FINGERTIP_RATE)[-1] == 74
