"""Tests that an excerpt around a contact equals that part of the whole pinch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pinches import drawn

from firstcontact.core import FINGERTIP_RATE, Label
from firstcontact.twin import (
    BLOCKS,
    BUFFER,
    CONDITIONS,
    EVERYDAY_OBJECTS,
    Condition,
    PinchDraw,
    excerpt,
    integrate_pinch,
    simulate_pinch,
)

BEFORE, DURATION = 0.04, 0.06


def silent(draw: PinchDraw) -> PinchDraw:
    """Return the draw without noise and jitter, with its contact at a sampling instant."""
    quiet = tuple(
        replace(n, rotor=0.0, mesh=0.0, friction=0.0, click_rate=0.0, mains=0.0) for n in draw.noise
    )
    first_contact = round(draw.timing.first * FINGERTIP_RATE) / FINGERTIP_RATE
    second_contact = first_contact + draw.timing.second - draw.timing.first
    timing = draw.timing._replace(first=first_contact, second=second_contact)
    return replace(draw, noise=quiet, jitter=0.0, timing=timing)


@pytest.mark.parametrize("condition", CONDITIONS.values(), ids=lambda c: c.name)
def test_excerpt_has_the_waveform_of_the_full_pinch(condition: Condition) -> None:
    for number, kind in enumerate((BLOCKS[0], BLOCKS[-1], *EVERYDAY_OBJECTS[::3])):
        draw = silent(drawn(kind, number, condition))
        _, waveform = integrate_pinch(draw)
        lead = round(BEFORE * FINGERTIP_RATE) / FINGERTIP_RATE
        _, part = integrate_pinch(excerpt(draw, lead), duration=DURATION)
        start = round((draw.timing.first - lead) * FINGERTIP_RATE)
        expected = waveform[start : start + len(part), :, BUFFER]
        error = np.abs(part[:, :, BUFFER] - expected).max() / np.abs(expected).max()
        # What is left is how far the vibration had settled.
        assert error < 1e-3


def test_excerpt_is_a_pinch_with_its_contacts() -> None:
    draw = drawn(BLOCKS[2])
    pinch = simulate_pinch(excerpt(draw, BEFORE), Label(), duration=DURATION)
    assert len(pinch.data) == round(DURATION * FINGERTIP_RATE)
    contact = pinch.first
    assert contact is not None
    assert contact.sample / FINGERTIP_RATE == pytest.approx(BEFORE, abs=2 / FINGERTIP_RATE)
