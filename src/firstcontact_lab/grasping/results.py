"""Records of the grasp study in ``results.json``."""

from __future__ import annotations

from typing import Any

import msgspec

from firstcontact.core import Record
from firstcontact.models import Bounded, Ends

#: Name of the ceiling: the best choice for each specimen, which no policy can reach.
CEILING = "ceiling"


class Summary(Record, frozen=True, kw_only=True):
    """Means and shares over closings. Intervals are from a bootstrap over whole sessions.

    Parameters
    ----------
    peak_n, squeeze_mm
        Mean peak force, N, and mean compression, mm, over all closings.
    steady, dropped, broken
        Share of closings with a steady grasp, a dropped object, and a broken object.
    time_ms
        Mean time of the steady grasps, ms; None without any.
    n, misses
        Number of closings, and of missed deadlines.
    intervals
        Intervals by the name of the number.
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
    """Chosen settings, with their scores on the tuning pinches."""

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
    options: dict[str, Any] | None = msgspec.field(default=None, name="asked")
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
    """Errors on held-out sessions, by window length, ms."""

    rmse: dict[str, float]
    interval_width: dict[str, float]


class Filmed(Record, frozen=True, kw_only=True):
    """Content of the film: two objects and the seed of the hand."""

    objects: list[str]
    hand: int
    specimen: int


#: Summaries by variant, latency (ms) and group of objects.
Policies = dict[str, dict[str, dict[str, Summary]]]


class Between(Record, frozen=True, kw_only=True):
    """Number with the ends of its 95 % interval."""

    value: float
    low: float
    high: float

    @property
    def bounded(self) -> Bounded:
        """The number with its interval as the reports show it."""
        return Bounded(self.value, (self.low, self.high))


class FrontPoints(Record, frozen=True, kw_only=True):
    """Points of a front: shares of dropped and damaged picks, from the most cautious scale on."""

    dropped: list[float]
    damaged: list[float]


class ChosenSettings(Record, frozen=True, kw_only=True):
    """Chosen settings of one fold, with shares of drops and damage on the tuning picks."""

    left_out: list[str]
    settings: dict[str, float]
    tried: int
    drops: float
    damage: float


class TunedOn(Record, frozen=True, kw_only=True):
    """Data for tuning: seeds of the hands, numbers of the specimens, and number of picks."""

    hands: list[int]
    specimens: list[int]
    picks: int
    budget: int
    folds: int
    families: list[list[str]]


class RealClosings(Record, frozen=True, kw_only=True):
    """Full closings of a tuned policy, with plant, detector, estimator and loop.

    ``success``: share neither dropped nor damaged. ``steady``: share with a steady grasp;
    ``steady_ms``: mean time to it. ``as_table``: share with the outcome that the table predicts.
    ``in_time``: share in which an estimate met the policy's deadline, if the policy has one.
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
    """Shares neither dropped nor damaged with a reflex, without and with stiffness."""

    blind: float
    stiffness: float


class Reflexes(Record, frozen=True, kw_only=True):
    """Drops with a reflex, for one kind of lift and one detection latency.

    ``blind`` and ``stiffness`` are the shares of drops of these policies, at the same damage as the
    main result. ``fewer`` is the relative reduction of drops by stiffness.
    """

    blind: Between
    stiffness: Between
    fewer: Between
    success: ReflexSuccess


class ObjectErrors(Record, frozen=True, kw_only=True):
    """Errors of the estimates of one object.

    ``rmse`` has an entry for each window, ms, and an entry "used" for the estimates that policies
    used. ``bias`` is the mean error of the used estimates.
    """

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

    ``rmse``: over all objects, by window, ms, and for "used" estimates. ``bearing``: the same over
    objects up to 70 Shore A. ``decided``: share of pinches with a complete window before the second
    contact.
    """

    rmse: dict[str, float]
    bearing: dict[str, float]
    decided: dict[str, float]
    block_rmse: float
    unanswered: float
    heard: float


class Household(Record, frozen=True, kw_only=True):
    """Results of the household: drops and damage with and without stiffness.

    Parameters
    ----------
    objects, hands
        Number of judged objects and hands.
    picks
        Number of judged picks: objects times hands times specimens.
    damage
        Share of damage at which drops are compared.
    success
        Share neither dropped nor damaged, by tuned policy; from full closings if there are some.
    drops_at_10_damage
        Drops at 10 % damage, by policy.
    drops_between
        The same shares with intervals over objects and hands.
    fewer_drops_than_blind
        Relative reduction of drops by the policy with live estimates, compared with ``blind``. In
        each resample both policies damage 10 %.
    fewer_drops_as_bold
        The same reduction with the same scales of the forces in all resamples. Each additional
        damaged object counts as dropped.
    success_gain
        Gain in success from stiffness with tuned policies, over the same full closings.
    fewer
        Like ``fewer_drops_than_blind``, for every policy without a reflex.
    target
        Target of the reduction.
    controls
        Gain that remains if weights, limits, or both are those of other objects.
    slip_reflex
        Drops with a slip reflex, by lift and detection latency.
    sensitivity
        Gain with changed estimated numbers of the objects.
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
    """Results of the payload task: hold objects up to a declared mass as gently as possible."""

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
        """Latency of the hand in the payload task, ms, as text: a key of ``payload.policies``."""
        return f"{self.payload.data.latencies_ms[0]:g}"
