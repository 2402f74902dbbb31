"""Records of the grasp study in ``results.json``."""

from __future__ import annotations

from firstcontact.core import Record
from firstcontact.models.scores import Ends
from firstcontact_lab.report.tables import Bounded

#: Name of the ceiling: the best choice for each specimen, which no policy can reach.
CEILING = "ceiling"
#: Key of the errors of the estimates that a policy acted on, beside the lengths of windows, ms.
USED = "used"
#: Largest Shore A in the scores without the firmest objects: the network was not trained on objects
#: that are much firmer.
FIRMEST = 70.0


class Summary(Record, frozen=True, kw_only=True):
    """Means and shares over closings. Intervals are bootstrap intervals over sessions."""

    peak_n: float
    squeeze_mm: float
    steady: float
    dropped: float
    broken: float
    time_ms: float | None = None
    n: int
    misses: int
    intervals: dict[str, Ends]


class Tuning(Record, frozen=True, kw_only=True):
    """Chosen settings of a variant in the payload task, with their scores on the tuning pinches."""

    settings: dict[str, float]
    tried: int
    peak: float
    time: float
    unsteady: float


class GraspData(Record, frozen=True, kw_only=True):
    """Objects and closings of the payload task, and number of pinches for training."""

    source: str
    objects: list[str]
    sessions: int
    pinches: int
    closings: int
    training: int
    latencies_ms: list[float]


class ModelErrors(Record, frozen=True, kw_only=True):
    """RMSE and interval width on held-out sessions, Shore A, by window length, ms."""

    rmse: dict[str, float]
    interval_width: dict[str, float]


class Filmed(Record, frozen=True, kw_only=True):
    """Content of the film: two objects, seed of the hand, and number of the specimens."""

    objects: list[str]
    hand: int
    specimen: int


#: Summaries by variant, latency (ms) and group of objects.
Policies = dict[str, dict[str, dict[str, Summary]]]


class Between(Record, frozen=True, kw_only=True):
    """Number and bounds of its 95 % interval."""

    value: float
    low: float
    high: float

    @property
    def bounded(self) -> Bounded:
        """Number with its interval, as the reports show it."""
        return Bounded(self.value, (self.low, self.high))


class FrontPoints(Record, frozen=True, kw_only=True):
    """Shares of dropped and of damaged picks at each scale, smallest scale first."""

    dropped: list[float]
    damaged: list[float]


class ChosenSettings(Record, frozen=True, kw_only=True):
    """Chosen settings of one fold, with the shares of drops and damage in the picks for tuning."""

    left_out: list[str]
    settings: dict[str, float]
    tried: int
    drops: float
    damage: float


class TunedOn(Record, frozen=True, kw_only=True):
    """Picks for tuning or for judging: seeds of the hands, numbers of the specimens, and counts."""

    hands: list[int]
    specimens: list[int]
    picks: int
    budget: int
    folds: int
    families: list[list[str]]


class RealClosings(Record, frozen=True, kw_only=True):
    """Shares of outcomes in the full closings of a tuned policy."""

    n: int
    success: float
    dropped: float
    damaged: float
    steady: float
    steady_ms: float | None = None
    as_table: float | None = None
    in_time: float | None = None
    intervals: dict[str, Ends]


class ReflexSuccess(Record, frozen=True, kw_only=True):
    """Shares of successes of two policies with a slip reflex."""

    blind: float
    stiffness: float


class Reflexes(Record, frozen=True, kw_only=True):
    """Drops with a slip reflex, for one kind of lift and one latency of the slip detection."""

    blind: Between
    stiffness: Between
    fewer: Between
    success: ReflexSuccess


class ObjectErrors(Record, frozen=True, kw_only=True):
    """Errors of the estimates of one object, and outcomes of its picks."""

    shore_a: float
    family: str
    fragile: bool
    n: int
    answered: int
    rmse: dict[str, float]
    bias: float | None = None
    drops: dict[str, float]
    damage: dict[str, float]


class Estimates(Record, frozen=True, kw_only=True):
    """Errors and times of the live estimates on the picks for judging."""

    rmse: dict[str, float]
    bearing: dict[str, float]
    decided: dict[str, float]
    block_rmse: float
    unanswered: float
    heard: float


class Household(Record, frozen=True, kw_only=True):
    """Results of the household part: drops and damage with and without stiffness."""

    objects: int
    hands: int
    picks: int
    damage: float
    success: dict[str, float]
    drops_at_10_damage: dict[str, float]
    drops_between: dict[str, Between]
    fewer_drops_than_blind: Between
    fewer_drops_as_bold: Between
    success_gain: Between
    fewer: dict[str, Between]
    target: float
    controls: dict[str, Between]
    slip_reflex: dict[str, Reflexes]
    sensitivity: dict[str, Between]
    fronts: dict[str, FrontPoints]
    closings: dict[str, RealClosings]
    estimates: Estimates
    by_object: dict[str, ObjectErrors]
    tuned: dict[str, list[ChosenSettings]]
    tuned_on: TunedOn
    judged_on: TunedOn

    @property
    def met(self) -> bool:
        """True if the reduction of drops reaches the target, and the interval excludes zero."""
        gain = self.fewer_drops_than_blind
        return gain.value >= self.target and gain.low > 0


class Payload(Record, frozen=True, kw_only=True):
    """Results of the payload task: to hold objects of at most an assumed mass gently."""

    data: GraspData
    models: ModelErrors
    feedback: dict[str, Tuning]
    policies: Policies

    @property
    def latency(self) -> str:
        """Latency of the hand, ms, as text: a key of ``policies``."""
        return f"{self.data.latencies_ms[0]:g}"
