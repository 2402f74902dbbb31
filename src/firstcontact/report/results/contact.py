"""How contacts were found, and when a stiffness could be told."""

from __future__ import annotations

from firstcontact.core.by_name import ByName, Record
from firstcontact.learning.detection import DetectionScores


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
    """What holds for all detectors.

    Parameters
    ----------
    windows_start_at
        A detector, or "known" for the labels' contacts.
    steady_state
        How many closings began in each way.
    folds, early_ms
        Where contacts are known: of the scores, and how late a label may be.
    not_found
        Of the detector that places the windows.
    """

    windows_start_at: str | None = None
    steady_state: dict[str, int] | None = None
    folds: DetectionFolds | None = None
    early_ms: float | None = None
    not_found: NotFound | None = None


#: Scores by the name of the detector.
ContactResults = ByName[DetectionScores, ContactConditions]


class Answers(Record, frozen=True, kw_only=True):
    """When windows of one length were complete, ms after the contact.

    Parameters
    ----------
    n, of
        Pinches with an answer, of how many.
    median, p95
        Of these, where there are any.
    before_second, with_second
        Share answered before the second contact, of how many where it is known.
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
