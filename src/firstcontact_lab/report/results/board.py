"""What models cost on the microcontroller, as ``make embedded`` has counted it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import msgspec

from firstcontact.core import LONGEST, InputError, Name, Record, read_record, read_regular
from firstcontact.export import microseconds

_Rate = Annotated[float, msgspec.Meta(gt=0)]
_Positive = Annotated[int, msgspec.Meta(gt=0)]


class BoardTime(Record, frozen=True, kw_only=True):
    """An answer of one form of a model on the board.

    ``estimator`` and ``task`` say which model it was made from, ``samples`` how many from the
    contact on it takes, at ``rate_hz``; ``instructions`` are those of its dearest answer, counted
    by the emulator.
    """

    estimator: Name
    task: Name
    samples: _Positive
    rate_hz: _Rate
    instructions: _Positive

    @property
    def signal_ms(self) -> float:
        """How long the samples last, ms."""
        return 1e3 * self.samples / self.rate_hz

    @property
    def microseconds(self) -> float:
        """How long it takes by the assumption of clock and cycles, us."""
        return microseconds(self.instructions)


class _Row(msgspec.Struct):
    # Detectors have no estimator, whole models that no board takes no instructions.
    estimator: Name | None = None
    task: Name | None = None
    samples: _Positive | None = None
    rate_hz: _Rate | None = None
    instructions: _Positive | None = None


class _Board(msgspec.Struct):
    models: dict[Name, _Row]


def read_board(path: Path) -> dict[str, BoardTime]:
    """Answers in an ``embedded.json``, by the names of their forms.

    Raises
    ------
    InputError
        It cannot be read, is none, or has no answers.
    """
    remedy = "give the embedded.json of `make embedded` of this version"
    rows = read_record(read_regular(path, LONGEST), _Board, str(path), remedy).models
    found = {
        name: BoardTime(
            estimator=row.estimator,
            task=row.task,
            samples=row.samples,
            rate_hz=row.rate_hz,
            instructions=row.instructions,
        )
        for name, row in rows.items()
        if row.estimator and row.task and row.samples and row.rate_hz and row.instructions
    }
    if not found:
        raise InputError(f"{path} has no models with instructions counted: {remedy}")
    return found
