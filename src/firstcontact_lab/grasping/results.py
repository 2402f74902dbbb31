"""Records of the grasp study in ``results.json``."""

from __future__ import annotations

from typing import Any

from firstcontact.core import Record
from firstcontact.models import Bounded, Ends

#: Among policies: the best that can be done to each specimen, which no policy can.
CEILING = "ceiling"


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


class Tuning(Record, frozen=True, kw_only=True):
    """Chosen settings, and their scores on the pinches for the choice."""

    settings: dict[str, float]
    tried: int
    peak: float
    time: float
    unsteady: float


class GraspRun(Record, frozen=True, kw_only=True):
    """Command and settings of the study."""

    command: str
    started: str
    seconds: float
    quick: bool
    seed: int
    workers: int
    asked: dict[str, Any] | None = None
    versions: dict[str, str]


class GraspData(Record, frozen=True, kw_only=True):
    """Objects of the closings, and number of pinches for training."""

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
    """Content of the film: two objects and the seed of the hand."""

    objects: list[str]
    hand: int
    specimen: int


#: Variant to latency (ms) to group of objects.
Policies = dict[str, dict[str, dict[str, Summary]]]


class Between(Record, frozen=True, kw_only=True):
    """A number and the ends of its 95 % interval."""

    value: float
    low: float
    high: float

    @property
    def bounded(self) -> Bounded:
        """The number with its interval as the reports show it."""
        return Bounded(self.value, (self.low, self.high))


class FrontPoints(Record, frozen=True, kw_only=True):
    """Shares of dropped and damaged picks, from the most cautious on."""

    dropped: list[float]
    damaged: list[float]


class ChosenSettings(Record, frozen=True, kw_only=True):
    """Choice of one fold, and its shares on the picks for the choice."""

    left_out: list[str]
    settings: dict[str, float]
    tried: int
    drops: float
    damage: float


class TunedOn(Record, frozen=True, kw_only=True):
    """Data for tuning: hands by seed, specimens by number, and number of picks."""

    hands: list[int]
    specimens: list[int]
    picks: int
    budget: int
    folds: int
    families: list[list[str]]


class RealClosings(Record, frozen=True, kw_only=True):
    """Closings of a policy as it was tuned, with plant, detector, estimator and loop in full.

    ``success`` is neither dropped nor damaged; ``steady_ms`` the mean time to a steady grasp,
    ``steady`` the share that has one; ``as_table`` the share with the table's outcome;
    ``in_time`` the share in which an estimate met the policy's deadline, if it has one.
    """

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
    """Shares that are neither dropped nor damaged, with a reflex: without stiffness and with it."""

    blind: float
    stiffness: float


class Reflexes(Record, frozen=True, kw_only=True):
    """With a reflex, for one way of lifting and one detection latency.

    ``blind`` and ``stiffness`` are drops at the headline's damage; ``fewer`` is what stiffness
    saves of those that a reflex alone drops.
    """

    blind: Between
    stiffness: Between
    fewer: Between
    success: ReflexSuccess


class ObjectErrors(Record, frozen=True, kw_only=True):
    """Estimates of one object: RMSE by window (ms) and of what was used, and the mean of that."""

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
    """Errors and times of the live estimates on judged picks.

    ``rmse`` over all by window, ms, and "used"; ``bearing`` over things up to 70 Shore A;
    ``decided`` is the share of pinches in which a window is whole before the second contact.
    """

    rmse: dict[str, float]
    bearing: dict[str, float]
    decided: dict[str, float]
    block_rmse: float
    unanswered: float
    heard: float


class Household(Record, frozen=True, kw_only=True):
    """The household: what a hand that knows stiffness drops and damages less.

    Parameters
    ----------
    objects, hands
        How many are judged.
    picks
        Judged ones: objects, hands and specimens.
    damage
        Share of damage at which drops are compared.
    success
        Share that is neither dropped nor damaged, by policy: as tuned, of real closings where
        there are some.
    drops_at_10_damage
        By policy.
    drops_between
        The same with intervals over objects and hands.
    fewer_drops_than_blind
        Of the policy that acts on the live estimate; in each resample both damage a tenth.
    fewer_drops_as_bold
        The same where in resamples both stay as bold as over all picks, and each thing that
        stiffness damages more than blind counts as dropped.
    success_gain
        By how much more of the same closings in full end well with stiffness than blind, as tuned.
    fewer
        As ``fewer_drops_than_blind``, of every policy that has no reflex.
    target
        What was to be reached.
    controls
        The gain that is left where weights, limits, or both are those of other things.
    slip_reflex
        By lift and detection latency.
    sensitivity
        The gain where estimated numbers of the objects are others.
    """

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
        """True if the gain reaches the target and its interval excludes zero."""
        gain = self.fewer_drops_than_blind
        return gain.value >= self.target and gain.low > 0


class Payload(Record, frozen=True, kw_only=True):
    """The older task: hold a declared payload as gently as can be; one table."""

    data: GraspData
    models: ModelErrors
    feedback: dict[str, Tuning]
    policies: Policies


class GraspResults(Record, frozen=True, kw_only=True):
    """Results of the grasp study."""

    study: GraspRun
    household: Household
    payload: Payload
    film: Filmed

    @property
    def latency(self) -> str:
        """The payload's, ms, as a key of policies."""
        return f"{self.payload.data.latencies_ms[0]:g}"
