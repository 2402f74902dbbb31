"""Output of the hand that only prints its commands."""

from __future__ import annotations

import io

from firstcontact.core import Command
from firstcontact.grasp._printing import PrintHand


def test_each_new_command_prints_one_line() -> None:
    out = io.StringIO()
    with PrintHand(out=out) as hand:
        for command in (
            Command(0.02, 2.0),
            Command(0.02, 2.0),
            Command(0.0, 1.0),
            Command(-0.1, 1),
        ):
            hand.send(command)
        assert len(hand.commands) == 4
    lines = [line.split("s  ")[1] for line in out.getvalue().splitlines()]
    assert lines == [
        "close at 20.0 mm/s, at most 2.00 N",
        "stop, at most 1.00 N",
        "open at 100.0 mm/s, at most 1.00 N",
        "release",
    ]


def test_closed_output_raises_no_error() -> None:
    out = io.StringIO()
    with PrintHand(out=out) as hand:
        hand.send(Command(0.02, 2.0))
        out.close()
        hand.release()
        assert hand.commands[-1] is None
