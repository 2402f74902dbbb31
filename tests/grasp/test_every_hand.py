"""What every registered hand must do; a new one is tested by being registered."""

from __future__ import annotations

import pytest

from firstcontact.core import Command
from firstcontact.grasp.hand import Hand, HandError
from firstcontact.grasp.registry import HANDS, open_hand


@pytest.fixture(params=HANDS, name="hand")
def made(request: pytest.FixtureRequest) -> Hand:
    """A hand that is not open, without hardware."""
    kind = HANDS[request.param]
    hand = kind.make(kind.rehearsal)
    assert hand.name == request.param
    return hand


def test_limits_are_limits(hand: Hand) -> None:
    limits = hand.limits
    assert 0 < limits.speed < 2
    assert 0 < limits.force < 100
    assert 0 < limits.rate < 10_000
    assert limits.watchdog > 1 / limits.rate, "else no rate is fast enough"


def test_it_takes_what_its_limits_allow(hand: Hand) -> None:
    limits = hand.limits
    with hand:
        for speed in (-limits.speed, 0.0, limits.speed):
            for force in (0.0, limits.force):
                hand.send(Command(speed, force))


def test_release_never_raises(hand: Hand) -> None:
    hand.release()
    with hand:
        hand.release()
        hand.release()
        hand.send(Command(0.0, 1.0))
        hand.release()
    hand.release()


def test_closing_twice_is_fine_and_closing_unopened_too(hand: Hand) -> None:
    with hand:
        hand.close()
        hand.close()
    hand.close()


def test_closing_what_was_never_opened_is_fine(hand: Hand) -> None:
    hand.close()


def test_an_exception_passes_and_closes(hand: Hand) -> None:
    with pytest.raises(ZeroDivisionError), hand:
        raise ZeroDivisionError
    with pytest.raises(HandError):
        hand.send(Command(0.0, 1.0))


def test_commands_need_an_open_hand(hand: Hand) -> None:
    with pytest.raises(HandError, match="not open"):
        hand.send(Command(0.0, 1.0))
    with hand:
        hand.send(Command(0.0, 1.0))
    with pytest.raises(HandError, match="not open"):
        hand.send(Command(0.0, 1.0))


@pytest.mark.parametrize("name", HANDS)
def test_it_can_be_made_safe(name: str) -> None:
    with open_hand(name, HANDS[name].rehearsal) as hand:
        hand.send(Command(1e6, 1e6))
        hand.alive()
        assert hand.counts.clipped == 1
    assert hand.counts.sent == 1
    assert hand.counts.released >= 1
    assert hand.failure is None
