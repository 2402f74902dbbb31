"""What every registered hand must do; a new one is tested by being registered."""

from __future__ import annotations

import pytest

from firstcontact.core import Command
from firstcontact.device import SOURCES, SourceOptions
from firstcontact.grasp import HANDS, HandError
from firstcontact.grasp._printing import PrintHand
from firstcontact.testing import check_hand


@pytest.mark.parametrize("name", HANDS)
def test_it_keeps_to_what_hands_promise(name: str) -> None:
    kind = HANDS[name]
    if kind.of_source is None:
        check_hand(kind)
        return
    with SOURCES[kind.of_source].make(kind.of_source, SourceOptions(speed=2, seed=4)) as source:
        check_hand(kind, source=source)


class Careless(PrintHand):
    """Takes commands at any time."""

    def send(self, command: Command) -> None:
        self._note(command)


class Mute(PrintHand):
    """Does not say why it takes none."""

    def send(self, command: Command) -> None:
        if not self._open:
            raise HandError("no")


class Stuck(PrintHand):
    """Cannot be released before it is opened."""

    def release(self) -> None:
        if not self._open:
            raise HandError("not open")


class Swallowing(PrintHand):
    """Hides what goes wrong."""

    def __exit__(self, *error: object) -> bool:  # type: ignore[override]
        self.close()
        return True


@pytest.mark.parametrize("kind", [Careless, Mute, Stuck, Swallowing])
def test_a_hand_that_does_otherwise_is_found_out(kind: type[PrintHand]) -> None:
    with pytest.raises((AssertionError, HandError)):
        check_hand(kind)
