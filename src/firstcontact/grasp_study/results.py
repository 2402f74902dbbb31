"""What the grasp study finds, as records: ``results.json``."""

from __future__ import annotations

from typing import Any

from firstcontact.core.by_name import ByName, Record
from firstcontact.learning.scores import Bounded, Ends


class Summary(Record, frozen=True, kw_only=True):
    """Means and shares over closings; intervals draw whole sessions.

    Parameters
    ----------
    peak_n, squeeze_mm
        Means over all closings.
    steady, dropped, broken
        Shares of them.
    time_ms
        Mean of the steady grasps, where there are some.
    n, misses
        Closings, and how many deadlines were missed.
    intervals
        By the name of the number.
    """

    peak_n: float
    squeeze_mm: float
    steady: float
    dropped: float
    broken: float
    time_ms: float | None = None
    n: int
    misses: int
    intervals: dict[str, Ends]


class Difference(Record, frozen=True, kw_only=True):
    """What one policy does to the same pinches otherwise than another.

    Parameters
    ----------
    less_peak
        By which share the mean peak force is lower.
    longer
        By which share the mean time to grasp is longer, of pinches steadily held by both.
    more_dropped, more_broken
        Pinches.
    n
        Pinches compared.
    intervals
        Of the two shares.
    """

    less_peak: float
    longer: float | None = None
    more_dropped: int
    more_broken: int
    n: int
    intervals: dict[str, Ends]

    @property
    def peak_change(self) -> Bounded:
        """By which share the mean peak force is higher."""
        ends = self.intervals.get("less_peak")
        return Bounded(-self.less_peak, (-ends[1], -ends[0]) if ends else None)


class Met(Record, frozen=True, kw_only=True):
    """Which parts of the target are met."""

    less_peak: bool
    more_dropped: bool
    longer: bool

    @property
    def all(self) -> bool:
        """Whether the target is met."""
        return self.less_peak and self.more_dropped and self.longer


class Comparison(Record, frozen=True, kw_only=True):
    """A candidate against another policy, on groups of objects."""

    soft: Difference
    lasting: Difference
    all: Difference
    met: Met


class Target(Record, frozen=True, kw_only=True):
    """What was to be reached, in the words of :class:`Difference`."""

    less_peak: float
    more_dropped: int
    longer: float


class HeadlineConditions(Record, frozen=True, kw_only=True):
    """Latency, what counts as soft (Shore A), the best baseline, and the target."""

    latency_ms: float
    soft_up_to: float
    best_feedback: str
    target: Target


class ObjectSummary(Record, frozen=True, kw_only=True):
    """One object; ``variants`` at the headline's latency."""

    shore_a: float
    breaks: bool
    variants: dict[str, Summary]


class Tuning(Record, frozen=True, kw_only=True):
    """What was chosen of how many, and how it did on the pinches that it was chosen on."""

    settings: dict[str, float]
    tried: int
    peak: float
    time: float
    unsteady: float


class GraspRun(Record, frozen=True, kw_only=True):
    """How the study was asked for."""

    command: str
    started: str
    seconds: float
    quick: bool
    seed: int
    workers: int
    asked: dict[str, Any] | None = None
    versions: dict[str, str]


class GraspData(Record, frozen=True, kw_only=True):
    """What was closed on, and how many pinches the models learned from."""

    source: str
    objects: list[str]
    sessions: int
    pinches: int
    closings: int
    training: int
    latencies_ms: list[float]


class ModelErrors(Record, frozen=True, kw_only=True):
    """On sessions held out, by length of the window, ms."""

    rmse: dict[str, float]
    interval_width: dict[str, float]


class Filmed(Record, frozen=True, kw_only=True):
    """What the film shows."""

    object: str
    session: int


#: Candidate to other policy to comparison.
Headline = ByName[dict[str, Comparison], HeadlineConditions]
#: Variant to latency (ms) to group of objects.
Policies = dict[str, dict[str, dict[str, Summary]]]


class GraspResults(Record, frozen=True, kw_only=True):
    """Everything; ``feedback`` has what was tuned, ``grip`` the rule from Shore A to a grip."""

    study: GraspRun
    data: GraspData
    models: ModelErrors
    grip: dict[str, Any]
    feedback: dict[str, Tuning]
    policies: Policies
    objects: dict[str, ObjectSummary]
    headline: Headline
    film: Filmed

    @property
    def latency(self) -> str:
        """The headline's, ms, as a key of policies."""
        return f"{self.headline.about.latency_ms:g}"
