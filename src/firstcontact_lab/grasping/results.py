"""Typed records of the grasp study, as stored in its ``results.json``."""

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


class Between(Record, frozen=True, kw_only=True):
    """Value with the lower and upper bound of its 95 % interval."""

    value: float
    low: float
    high: float

    @property
    def bounded(self) -> Bounded:
        return Bounded(self.value, (self.low, self.high))


class FrontPoints(Record, frozen=True, kw_only=True):
    dropped: list[float]
    damaged: list[float]


class ChosenSettings(Record, frozen=True, kw_only=True):
    """Settings of a policy that were tuned without the objects in ``left_out``.

    ``drops`` and ``damage`` are the shares of the tuning picks that are dropped and damaged with
    these settings.
    """

    left_out: list[str]
    settings: dict[str, float]
    tried: int
    drops: float
    damage: float


class PickSummary(Record, frozen=True, kw_only=True):
    """Description of the picks that were used for tuning or for judging.

    ``hands`` are seeds, ``specimens`` are numbers, and ``picks`` is a count.
    """

    hands: list[int]
    specimens: list[int]
    picks: int
    budget: int
    folds: int
    families: list[list[str]]


class FullClosingShares(Record, frozen=True, kw_only=True):
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
    blind: float
    stiffness: float


class Reflexes(Record, frozen=True, kw_only=True):
    """Shares of dropped picks with a slip reflex, for one type of lift and one latency."""

    blind: Between
    stiffness: Between
    fewer: Between
    success: ReflexSuccess


class ObjectErrors(Record, frozen=True, kw_only=True):
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
    rmse: dict[str, float]
    bearing: dict[str, float]
    decided: dict[str, float]
    block_rmse: float
    unanswered: float
    heard: float


class Household(Record, frozen=True, kw_only=True):
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
    closings: dict[str, FullClosingShares]
    estimates: Estimates
    by_object: dict[str, ObjectErrors]
    tuned: dict[str, list[ChosenSettings]]
    tuned_on: PickSummary
    judged_on: PickSummary

    @property
    def met(self) -> bool:
        """True if the reduction of drops reaches the target, and its 95 % interval is above 0."""
        gain = self.fewer_drops_than_blind
        return gain.value >= self.target and gain.low > 0
