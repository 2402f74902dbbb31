"""What comes of asking somebody's regressor what ours are asked."""

from __future__ import annotations

from firstcontact.core import Record
from firstcontact.models import AnytimeScores
from firstcontact_lab.report.results.anytime import Generalised


class Benchmarked(Record, frozen=True, kw_only=True):
    """Of one condition: off the blocks, and of unseen objects by the time after the contact."""

    generalise: Generalised
    anytime: dict[str, AnytimeScores]


class BenchmarkResults(Record, frozen=True, kw_only=True):
    """``results.json`` of a benchmark: who was asked, how, and what came of it by condition."""

    contender: str
    command: str
    quick: bool
    seed: int
    seconds: float
    versions: dict[str, str]
    conditions: dict[str, Benchmarked]
