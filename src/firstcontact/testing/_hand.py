"""Check of a hand, such as that of a plug-in."""

from __future__ import annotations

from collections.abc import Callable
from math import inf

from firstcontact.core import Command
from firstcontact.device import Source
from firstcontact.grasp import Hand, HandError, SafeHand
from firstcontact.grasp.registry import make_hand
from firstcontact.testing.synthetic import passes_exceptions

_STILL = Command(0.0, 1.0)


def check_hand(
    hand_class: type[Hand], port: str | None = None, source: Source | None = None
) -> None:
    """Assert that a hand behaves as :class:`~firstcontact.grasp.Hand` requires.

    The hand moves during the checks, so take objects out of a real hand.

    The checks cover these requirements:

    - The limits and the reported positions are plausible.
    - Inside its ``with`` block the hand accepts all commands within the limits. Outside it, the
      hand refuses commands.
    - ``release`` and ``close`` work at any time, even if they are called twice.
    - An exception in the ``with`` block closes the connection and reaches the caller.
    - The hand works inside a :class:`firstcontact.grasp.SafeHand`.

    Parameters
    ----------
    hand_class
        Class of the hand.
    port
        Port of the hand; by default its ``simulated_port``.
    source
        Open source through which the hand is driven; None for a hand with a port.

    Raises
    ------
    AssertionError
        A check failed; the message names it.
    InputError
        The hand cannot be reached.

    Examples
    --------
    >>> from firstcontact.grasp import HANDS
    >>> check_hand(HANDS["print"])
    """

    def make() -> Hand:
        hand = make_hand(hand_class, hand_class.simulated_port if port is None else port, source)
        assert hand.name == hand_class.name, (
            f"the hand's name is {hand.name!r}, and its class's name {hand_class.name!r}"
        )
        return hand

    assert hand_class.begins, "the hand does not state how its closings begin"
    assert hand_class.name.isidentifier(), (
        f"the name {hand_class.name!r} may contain only letters, digits and _"
    )
    _limits(make)
    _takes_while_open(make)
    _reports(make)
    _releases(make)
    _passes_exceptions(make)
    _safe(make)


def _limits(make: Callable[[], Hand]) -> None:
    limits = make().limits
    assert 0 < limits.speed < 2, f"{limits.speed} m/s is not plausible for a fingertip"
    assert 0 < limits.force < 100, f"{limits.force} N is not plausible for a fingertip"
    assert 0 < limits.rate < 10_000, f"{limits.rate} Hz is not plausible for commands"
    assert limits.watchdog > 1 / limits.rate, (
        "the hand's watchdog is shorter than the time between commands"
    )
    hand = make()
    assert hand.position_rate == 0 or 1 <= hand.position_rate <= 2000, (
        f"{hand.position_rate} Hz is not plausible for positions"
    )
    assert 1e-9 <= hand.position_resolution <= 1e-2, (
        f"{hand.position_resolution} m is not plausible as the resolution of positions"
    )


def _takes_while_open(make: Callable[[], Hand]) -> None:
    hand = make()
    limits = hand.limits
    _refuses(hand, "before it is opened")
    with hand:
        for speed in (-limits.speed, 0.0, limits.speed):
            for force in (0.0, limits.force):
                hand.send(Command(speed, force))
    _refuses(hand, "after it was closed")


def _reports(make: Callable[[], Hand]) -> None:
    with SafeHand(make()) as hand:
        try:
            for _ in range(50):  # the process of a separate hand may answer late
                hand.positions_since(-inf, 0.0)
                hand.closing_speed(0.0, 0.0)
        except HandError as error:
            raise AssertionError(str(error)) from error


def _releases(make: Callable[[], Hand]) -> None:
    make().close()
    hand = make()
    hand.release()
    with hand:
        hand.release()
        hand.send(_STILL)
        hand.release()
        hand.close()
        hand.close()
    hand.release()
    hand.close()


def _passes_exceptions(make: Callable[[], Hand]) -> None:
    hand = make()
    passes_exceptions(hand, "hand")
    _refuses(hand, "after an exception")


def _refuses(hand: Hand, when: str) -> None:
    message = None
    try:
        hand.send(_STILL)
    except HandError as error:
        message = str(error)
    assert message is not None, f"the hand accepts a command {when}"
    assert "not open" in message, f"{when} the error {message!r} does not contain 'not open'"


def _safe(make: Callable[[], Hand]) -> None:
    with SafeHand(make()) as hand:
        hand.send(Command(1e6, 1e6))
        hand.alive()
        assert hand.counts.clipped == 1, "a command beyond its limits is not clipped"
    assert hand.counts.sent == 1, f"{hand.counts.sent} commands were sent instead of one"
    assert hand.counts.released >= 1, "the hand was not released"
    assert hand.failure is None, f"the hand failed: {hand.failure}"
