"""Tests of the texts between host and twin."""

from __future__ import annotations

from math import isfinite

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Command, InputError
from firstcontact.device import concerns_hand, held_object, lost_object, object_text, order_text
from firstcontact.device._twin_words import ACCEPTED, lost_text, peak_text, read_order
from firstcontact.twin._objects import OBJECTS


@given(st.floats(-1.0, 1.0), st.floats(0.0, 100.0))
def test_order_text_round_trips(speed: float, force: float) -> None:
    command = read_order(order_text(Command(speed, force)))
    assert command is not None
    assert command.speed == pytest.approx(speed, abs=5.1e-5)
    assert command.force == pytest.approx(force, abs=5.1e-4)
    assert read_order(order_text(None)) is None


@given(st.text(max_size=30))
def test_other_hand_texts_are_refused_or_ignored(text: str) -> None:
    try:
        order = read_order("hand:" + text)
    except InputError:
        return
    assert order is None or (isfinite(order.speed) and isfinite(order.force))


def test_object_texts_differ_from_hand_texts() -> None:
    for name in OBJECTS:
        assert held_object(f"twin: {name}") == name
        assert not concerns_hand(f"twin: {name}")
    about = (peak_text(3.44), ACCEPTED + order_text(None), ACCEPTED + object_text("apple 1"))
    for text in (*about, "twin: hand is not closing", "hand: release", "hand: -0.0160 2.551"):
        assert held_object(text) is None
        assert concerns_hand(text)
    for text in ("an apple", "hand: my left one", "hand: 0.0160 2.551 or so"):
        assert held_object(text) is None
        assert not concerns_hand(text)
    assert peak_text(3.44) == "twin: peak 3.4 N"


def test_loss_texts_concern_the_hand() -> None:
    for loss in ("dropped", "broken"):
        assert lost_object(lost_text(loss)) == loss
        assert concerns_hand(lost_text(loss))
        assert held_object(lost_text(loss)) is None
    assert lost_object(peak_text(3.0)) is None
