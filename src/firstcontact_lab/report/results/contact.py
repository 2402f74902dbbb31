"""How contacts were found, and when a stiffness could be told."""

from __future__ import annotations

from firstcontact.core import ByName, Record
from firstcontact.models import DetectionScores


class DetectionFolds(Record, frozen=True, kw_only=True):
    """How many folds, what they held out, and what both sides share."""

    n: int
    held_out: str
    shares: list[str]


class NotFound(Record, frozen=True, kw_only=True):
    """Pinches in which a detector found no contact, of how many."""

    by: str
    pinches: int
    of: int


class ContactConditions(Record, frozen=True, kw_only=True):
    """For all detectors: where windows start ("known" for the labels), and how closings began.

    ``folds`` and ``early_ms`` (how late a label may be) are of scores; ``not_found`` is of the one
    that places windows.
    """

    windows_start_at: str | None = None
    steady_state: dict[str, int] | None = None
    folds: DetectionFolds | None = None
    early_ms: float | None = None
    not_found: NotFound | None = None


#: Scores by the name of the detector.
ContactResults = ByName[DetectionScores, ContactConditions]


class Answers(Record, frozen=True, kw_only=True):
    """When windows of one length were complete, ms after the contact: ``n`` pinches ``of`` so many.

    ``before_second``: share that this was before the second contact, of ``with_second`` pinches.
    """

    n: int
    of: int
    median: float | None = None
    p95: float | None = None
    before_second: float | None = None
    with_second: int | None = None


class AnswerTimes(Answers, frozen=True, kw_only=True):
    """Of the usual window, and of every length by its name, ms."""

    window_length_ms: dict[str, Answers]
