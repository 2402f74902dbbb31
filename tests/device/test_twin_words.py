"""Tests of the texts between host and twin."""

from __future__ import annotations

from math import isfinite

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Command, InputError
from firstcontact.device import concerns_hand, held_object, lost_object, object_text, order_text
from firstcontact.device._twin_words import TOLD, lost_text, peak_text, read_order
from firstcontact.twin._objects import OBJECTS


@given(st.floats(-1.0, 1.0), st.floats(0.0, 100.0))
def test_an_order_is_read_as_it_was_meant(speed: float, force: float) -> None:
    read = read_order(order_text(Command(speed, force)))
    assert read is not None
    assert read.speed == pytest.approx(speed, abs=5.1e-5)
    assert read.force == pytest.approx(force, abs=5.1e-4)
    assert read_order(order_text(None)) is None


@given(st.text(max_size=30))
def test_whatever_else_is_said_is_refused_in_words(text: str) -> None:
    try:
        order = read_order("hand:" + text)
    except InputError:
        return
    assert order is None or (isfinite(order.speed) and isfinite(order.force))


def test_only_an_object_is_taken_for_one() -> None:
    for name in OBJECTS:
        assert held_object(f"twin: {name}") == name
        assert not concerns_hand(f"twin: {name}")
    about = (peak_text(3.44), TOLD + order_text(None), TOLD + object_text("apple 1"))
    for text in (*about, "twin: hand is not closing", "hand: release", "hand: -0.0160 2.551"):
        assert held_object(text) is None
        assert concerns_hand(text)
    for text in ("an apple", "hand: my left one", "hand: 0.0160 2.551 or so"):
        assert held_object(text) is None
        assert not concerns_hand(text)
    assert peak_text(3.44) == "twin: peak 3.4 N"


def test_what_was_lost_is_about_the_hand_and_no_object() -> None:
    for how in ("dropped", "broken"):
        assert lost_object(lost_text(how)) == how
        assert concerns_hand(lost_text(how))
        assert held_object(lost_text(how)) is None
    assert lost_object(peak_text(3.0)) is None
