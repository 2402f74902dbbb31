"""Scores with their intervals."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from firstcontact.models import Ends


class Scores(Protocol):
    """Interface of score records that have intervals."""

    @property
    def intervals(self) -> dict[str, Ends]:
        """Interval of each score, by its name."""
        ...


class Bounded(NamedTuple):
    """Score with its interval, if it has one."""

    value: float
    ends: Ends | None = None


def bounded(scores: Scores | None, name: str) -> Bounded | None:
    """Return a score of a record with its interval; None if the record lacks the score."""
    value = getattr(scores, name, None)
    return None if scores is None or value is None else Bounded(value, scores.intervals.get(name))
