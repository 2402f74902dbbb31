"""The twin's hand, which takes commands over the twin's serial line, and its default model."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib.metadata import version
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Self

from firstcontact.core import Command, InputError
from firstcontact.core.files import cache_path, make_once
from firstcontact.core.installation import require_extra
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.device import Source
from firstcontact.device.twin_words import CLOSE_ORDER, order_text
from firstcontact.grasp import Hand, HandError, HandLimits
from firstcontact.grasp.hand import Begins
from firstcontact.twin.drive import EVERY, Drive

if TYPE_CHECKING:
    from firstcontact.models import Model

#: Highest rate of commands, Hz: the twin makes its samples 5 ms at a time.
RATE = 200.0
#: Folder of the model for the twin's default hand (``make twin-model``), with condition and seed.
SHIPPED = Path(__file__).parents[1] / "twin" / "pretrained"
SHIPPED_HAND = "paper-rig", 0
#: Number of training pinches of each block: few, to simulate and train in half a minute.
PINCHES = 60
#: Version of the twin, the training and the model format; a new one replaces cached models and
#: sample data.
RECIPE = 7


class TwinHand(Hand):
    """Hand that sends each command as an order to the twin for the current closing."""

    name = "twin"
    limits = HandLimits(speed=Drive().speed, force=Drive().force, rate=RATE, watchdog=inf)
    real = False
    begins = Begins.OTHERS | Begins.HURRY
    of_source = name
    position_rate = FINGERTIP_RATE / EVERY

    def __init__(self, source: Source) -> None:
        self._source = source
        self._open = False

    def send(self, command: Command) -> None:
        self._order(order_text(command))

    def start(self) -> None:
        self._order(CLOSE_ORDER)

    def positions_since(self, since: float, host_zero: float) -> Sequence[tuple[float, float]]:
        """Return the positions of the twin's drives after a time."""
        if not self._open:
            return ()
        try:
            return self._source.positions_since(since)
        except InputError as error:
            raise HandError(str(error)) from error

    def release(self) -> None:
        if not self._open:
            return
        with suppress(InputError):  # a twin that has ended holds nothing
            self._source.order(order_text(None))

    def close(self) -> None:
        self.release()
        self._open = False

    def _order(self, text: str) -> None:
        if not self._open:
            raise HandError(f"the hand {self.name!r} is not open: use it in a with block")
        try:
            self._source.order(text)
        except InputError as error:
            raise HandError(str(error)) from error

    def __enter__(self) -> Self:
        if self._source.descriptor.source != "twin":
            raise HandError(f"{self._source.name} is not the twin: use --device twin")
        self._open = True
        return self


def default_model(source: Source) -> Model:
    """Return the model for a source, open or not, for which the user names none."""
    from firstcontact.models import load_model
    from firstcontact.models.model import shipped_model

    hand = source.twin_hand
    return shipped_model() if hand is None else load_model(twin_model(*hand))


def twin_model(condition: str, seed: int) -> Path:
    """Return the folder of a model for the twin, which is trained if there is none."""
    from firstcontact.models import ESTIMATORS

    if (condition, seed) == SHIPPED_HAND:
        return SHIPPED
    require_extra(ESTIMATORS[ESTIMATORS.default])  # before the simulation
    folder = cache_path(f"twin-{version('firstcontact')}.{RECIPE}-{condition}-{seed}")

    def make(making: Path) -> None:
        from firstcontact.models import train
        from firstcontact.recording import load_dataset
        from firstcontact.twin import simulate

        print(
            f"no model was given; training one on the twin, saved in {folder} for the next start",
            file=sys.stderr,
        )
        pinches = making.with_name("pinches")
        simulate(pinches, condition, PINCHES, pinches_per_object=0, seed=seed)
        model = train(load_dataset(pinches))
        model.save(making)
        for line in model.notes:
            print(line, file=sys.stderr)

    make_once(folder, make)
    return folder
