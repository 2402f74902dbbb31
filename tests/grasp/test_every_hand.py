"""Conformance tests of all registered hands, plug-ins included."""

import io

import pytest

from firstcontact.core import Command
from firstcontact.device import SOURCES
from firstcontact.device.opening import SourceOptions
from firstcontact.grasp import HANDS, HandError
from firstcontact.grasp.printing import PrintHand
from firstcontact.testing import check_hand


@pytest.mark.parametrize("name", HANDS)
def test_registered_hand_passes_the_conformance_check(name: str) -> None:
    kind = HANDS[name]
    if kind.of_source is None:
        check_hand(kind)
        return
    with SOURCES[kind.of_source].make(kind.of_source, SourceOptions(speed=2, seed=4)) as source:
        check_hand(kind, source=source)


class Stuck(PrintHand):
    """Faulty hand that cannot be released before it is opened."""

    def release(self) -> None:
        if not self._open:
            raise HandError("not open")


class Swallowing(PrintHand):
    """Faulty hand that hides exceptions."""

    def __exit__(self, *error: object) -> bool:  # type: ignore[override]
        self.close()
        return True


@pytest.mark.parametrize("kind", [Stuck, Swallowing])
def test_conformance_check_rejects_a_faulty_hand(kind: type[PrintHand]) -> None:
    with pytest.raises((AssertionError, HandError)):
        check_hand(kind)


def test_the_print_hand_prints_each_new_command_until_its_output_is_closed() -> None:
    out = io.StringIO()
    with PrintHand(out=out) as hand:
        for speed in (0.02, 0.02, 0.0, -0.1):
            hand.send(Command(speed, 1.0))
        assert len(out.getvalue().splitlines()) == 3
        out.close()
        hand.release()
        assert hand.commands[-1] is None


def test_a_hand_that_moves_needs_live_samples_except_at_its_simulated_port() -> None:
    ability = HANDS["ability"]
    assert ability.needs_live_samples(None)
    assert ability.needs_live_samples("/dev/ttyUSB0")
    assert not ability.needs_live_samples(ability.simulated_port)
    assert not HANDS["print"].needs_live_samples(None)
