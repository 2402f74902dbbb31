"""What was recorded."""

from __future__ import annotations

from firstcontact.core import Record


class DataSummary(Record, frozen=True, kw_only=True):
    """Counts of a dataset, where it comes from, and what its import assumed.

    ``model_rate_hz`` is there where the models' rate is another than the recordings'.
    """

    source: str
    pinches: int
    specimens: int
    sample_rate_hz: float
    model_rate_hz: float | None = None
    sessions: int
    train_pinches: int
    test_pinches: int
    objects: list[str]
    notes: list[str]


class Offsets(Record, frozen=True, kw_only=True):
    """Times from the first to the second contact, ms; ``sd`` of two pinches or more."""

    mean: float
    sd: float | None = None
    share_below_15: float
    share_below_8: float
    median: float
    n: int


class PeakVoltage(Record, frozen=True, kw_only=True):
    """Peaks of the windows of one Shore A level, V."""

    mean: float
    sd: float | None = None
    n: int
