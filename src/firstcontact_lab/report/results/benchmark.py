"""What comes of asking somebody's regressor what ours are asked."""

from __future__ import annotations

from firstcontact.core import Record
from firstcontact.models import AnytimeScores
from firstcontact_lab.report.results.anytime import Generalised


class Benchmarked(Record, frozen=True, kw_only=True):
    """Of one condition: off the blocks, and of unseen objects by the time after the contact."""

    generalise: Generalised
    anytime: dict[str, AnytimeScores]


class RecordedScores(Record, frozen=True, kw_only=True):
    """Scores of one group of recorded pinches, by competitor.

    ``learned``: pinches to learn from, on average over ``folds``. ``cluster`` is "session" or
    "specimen": bootstrap intervals resample whole ones of the ``clusters`` that were scored.
    """

    learned: float
    folds: int
    cluster: str
    clusters: int
    scores: dict[str, AnytimeScores]


class RecordedData(Record, frozen=True, kw_only=True):
    """Recordings of a benchmark and the scores on them.

    ``held_out``: pinches of role "train", in folds that hold out whole sessions or specimens.
    ``objects``: pinches of role "test", by models that learned from all of role "train";
    ``left_out`` says why there are none. ``unused``: pinches without contact or Shore A;
    ``too_short``: pinches whose second contact came before any estimate.
    """

    path: str
    source: str
    pinches: int
    unused: int
    too_short: int
    levels: list[float]
    contacts: str
    held_out: RecordedScores
    objects: RecordedScores | None = None
    left_out: str = ""


class BenchmarkResults(Record, frozen=True, kw_only=True):
    """``results.json`` of a benchmark: who was asked, how, and what came of it.

    Scores are by condition of the twin, or those of ``recordings``.
    """

    contender: str
    command: str
    quick: bool
    seed: int
    seconds: float
    versions: dict[str, str]
    conditions: dict[str, Benchmarked]
    recordings: RecordedData | None = None
