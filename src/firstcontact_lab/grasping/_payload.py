"""Payload task: trained models, policies with each kind of taxels, their tuning and closings.

A policy that needs no force arrays has one variant; others also have a variant with ideal taxels.
"""

from __future__ import annotations

import logging
import math
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np

import firstcontact as fc
from firstcontact.chain.image import CONFIRMED
from firstcontact.core import Block, Estimate, InputError
from firstcontact.core.jobs import Runner, Serial
from firstcontact.grasp import POLICIES, Grip, Policy
from firstcontact.grasp.loop import LoopCounts
from firstcontact.grasp.policy import ForceArray, PolicyRole, SensorVariant, Task, Truth
from firstcontact.grasp.registry import make_policy
from firstcontact.models.scores import cluster_intervals
from firstcontact.models.window_model import Values
from firstcontact.signal import samples_in
from firstcontact.streaming import (
    ClosingStart,
    ContactEvent,
    ContactWithdrawn,
    NoEstimate,
    Pipeline,
)
from firstcontact.streaming.grasping import Grasping
from firstcontact.streaming.predictors import WindowLadder
from firstcontact.twin import draw_pinch, simulate
from firstcontact.twin.draw import condition, draw_specimen
from firstcontact.twin.drive import Drive
from firstcontact.twin.mechanics import OPTIMISTIC, VelostatParameters
from firstcontact.twin.plant import GraspPlant
from firstcontact_lab.grasping._hands import BLOCK, CONDITION, LAYOUT, Order, PlantHand
from firstcontact_lab.grasping.results import (
    GraspData,
    ModelErrors,
    Payload,
    Policies,
    Summary,
    Tuning,
)
from firstcontact_lab.grasping.settings import HEADLINE, KINDS, SOFT, GraspStudySettings
from firstcontact_lab.report.run import MARK, fresh

#: Number of samples of a block when no policy reads the force arrays.
LONG = 50
#: Number of finalists of the first round, which are compared on more pinches.
FINALISTS = 12
#: Largest additional time to a steady grasp, relative to a closing without modulation.
SLOWER = 0.10
#: Objects of the first round: a soft object, and the heaviest object.
FIRST_ROUND = ("block 10", "orange 1")
_VELOSTAT: Mapping[ForceArray, VelostatParameters | None] = {
    ForceArray.DRAWN: None,
    ForceArray.IDEAL: OPTIMISTIC,
}
#: Tuned settings of the policy of each variant, by the key of the variant.
Tuned = Mapping[str, Mapping[str, float]]
_log = logging.getLogger("firstcontact_lab.grasping")


def learn(settings: GraspStudySettings, out: Path) -> fc.Model:
    """Simulate pinches, train a detector and a window model for each length, and save them."""
    models = out / "models"
    # A study makes models after marked recordings. Without these, no study made the models.
    if models.exists() and not (out / "recordings" / MARK).exists():
        raise InputError(
            f"{models} was not made by a grasp study: choose another --out, or move it away"
        )
    recordings = fresh(out / "recordings", {"twin": CONDITION, "seed": settings.seed})
    if models.exists():
        shutil.rmtree(models)
    # The workers of the study stay in use, so this training must not start its own.
    simulate(
        recordings / "pinches", CONDITION, settings.training, 0, settings.seed, runner=Serial()
    )
    model = fc.train(
        fc.load(recordings),
        settings.model,
        detector=settings.detector,
        windows=settings.windows,
        seed=settings.seed,
    )
    return fc.load_model(model.save(models))


def payload(settings: GraspStudySettings, model: fc.Model, runner: Runner) -> Payload:
    """Tune the policies, and simulate each variant on each pinch at each latency of the drive."""
    tuned = search(settings, runner)
    best = {key: tuning.settings for key, tuning in tuned.items()}
    compared = tuple(variants().values())
    trials = [
        Trial(PinchSetup(k, s, seed=settings.seed), compared, settings.latencies, best)
        for s in range(settings.sessions)
        for k in settings.kinds
    ]
    rows = [row for rows in runner.map(run_trial, trials, model) for row in rows]
    return Payload(
        data=GraspData(
            source="twin",
            objects=list(settings.kinds),
            sessions=settings.sessions,
            pinches=settings.sessions * len(settings.kinds),
            closings=len(rows),
            training=5 * settings.training,
            latencies_ms=[round(1e3 * latency, 3) for latency in settings.latencies],
        ),
        models=_held_out_errors(model),
        feedback=tuned,
        policies=by_policy(rows, settings.seed),
    )


def _held_out_errors(model: fc.Model) -> ModelErrors:
    """Return a model's errors and interval widths on held-out sessions, by window length, ms."""
    rmse, width = {}, {}
    for window in model.windows:
        key = f"{1e3 * window.duration:g}"
        rmse[key] = window.record.scores["rmse"]
        held_out = window.record.calibration.get("held_out") or {}
        width[key] = float(held_out.get("mean_width", 0.0))
    return ModelErrors(rmse=rmse, interval_width=width)


@dataclass(frozen=True, slots=True)
class Variant:
    """Policy with one kind of taxels: with random errors, or ideal."""

    key: str
    title: str
    policy: type[Policy]
    velostat: VelostatParameters | None = None

    def make(self, grip: Grip, shore_a: float, settings: Mapping[str, float]) -> Policy:
        """Return the tuned policy for one pinch."""
        return make_policy(self.policy, grip, Truth(shore_a), settings)


def variants() -> dict[str, Variant]:
    """Return the variants by key: each policy of the payload task, with each kind of taxels."""
    by_key: dict[str, Variant] = {}
    for policy in POLICIES.values():
        if policy.task is not Task.PAYLOAD:
            continue
        as_it_is = SensorVariant(policy.name, policy.title, policy.colour)
        for sensors in policy.variants or (as_it_is,):
            if sensors.key in by_key:
                _log.warning(
                    "policy %s of %s is left out, because another policy has this name",
                    sensors.key,
                    policy.name,
                )
                continue
            velostat = _VELOSTAT[sensors.force_array]
            by_key[sensors.key] = Variant(sensors.key, sensors.title, policy, velostat)
    return by_key


def unmodulated() -> Variant:
    """Return the variant that does not adapt its force, with which the others are compared."""
    return next(v for v in variants().values() if v.policy.part is PolicyRole.UNMODULATED)


@dataclass(frozen=True, slots=True)
class PinchSetup:
    """Object and session of a random pinch."""

    kind: str
    session: int
    group: str = "grasp"
    seed: int = 0


@dataclass(frozen=True, slots=True)
class ClosingRecord:
    """Commands and estimates of one closing, and counts such as missed deadlines."""

    orders: tuple[Order, ...]
    estimates: tuple[Estimate, ...]
    counts: LoopCounts


def trial_plant(setup: PinchSetup, variant: Variant, latency: float) -> GraspPlant:
    """Return the hand before closing. The random draws are the same for all policies."""
    rig = condition(CONDITION)
    # Each session has another specimen. The first specimens are left out: models were trained on
    # them.
    place = 1 + 2 * setup.session + (setup.group == "grasp")
    specimen = draw_specimen(setup.seed, rig, KINDS[setup.kind], place)
    draw = draw_pinch(setup.seed, rig, f"{setup.group}-{setup.session}", specimen, setup.kind)
    return GraspPlant(draw, Drive(latency=latency), specimen, variant.velostat)


def close_on(
    plant: GraspPlant, setup: PinchSetup, variant: Variant, tuned: Tuned, model: fc.Model | None
) -> ClosingRecord:
    """Simulate a closing on the object of the setup, with the policy of the variant."""
    # The policy knows the drawn approach speed.
    grip = Grip(speed=plant.nominal.speed, force=plant.nominal.force)
    policy = variant.make(grip, KINDS[setup.kind].shore_a, tuned.get(variant.key, {}))
    feels = policy.uses_force()
    if not policy.uses_piezos() or model is None:
        return close(plant, policy, feels=feels)
    windows = model.windows if policy.deadline is not None else ()
    predictor = WindowLadder(windows) if windows else None
    pipeline = Pipeline(LAYOUT, model.own_detector, predictor, clock=lambda: 0.0)
    return close(plant, policy, pipeline, len(windows), feels)


def close(
    plant: GraspPlant,
    policy: Policy,
    pipeline: Pipeline | None = None,
    windows: int = 0,
    feels: bool = True,
) -> ClosingRecord:
    """Close the hand on the plant's object, until the object is lifted or lost."""
    hand = PlantHand(plant)
    grasping = Grasping(policy, hand, LAYOUT)
    estimates: list[Estimate] = []
    listening = pipeline is not None
    certain = math.inf  # sample from which on the first contact stands
    settled = False
    if pipeline is None:
        grasping.on_event(ClosingStart(0, 0))
    while not plant.ended:
        counts = grasping.loop.counts
        has_acted = counts.contacts > 0 and counts.misses + counts.estimates > 0
        waiting = policy.deadline is not None and not has_acted
        first = plant.sample
        block = Block(plant.advance(BLOCK if listening or waiting or feels else LONG), first)
        if listening and pipeline is not None:
            for event in pipeline.update(block, 0.0):
                if isinstance(event, ContactEvent) and event.first:
                    certain = event.contact.decided + samples_in(CONFIRMED, LAYOUT.rate)
                elif isinstance(event, ContactWithdrawn):
                    certain, settled = math.inf, False
                    estimates.clear()
                settled |= isinstance(event, NoEstimate)
                if isinstance(event, Estimate):
                    # The published study compares whole windows, also where the second contact is
                    # within a window.
                    if event.final:
                        settled = True
                        continue
                    estimates.append(event)
                grasping.on_event(event)
            listening = block.end < certain or not (settled or len(estimates) >= windows)
        grasping.after_block(block)
    return ClosingRecord(tuple(hand.orders), tuple(estimates), grasping.loop.counts)


@dataclass(frozen=True, slots=True)
class Trial:
    """Job that closes the hand on one setup, with all variants at all latencies of the drive."""

    setup: PinchSetup
    variants: tuple[Variant, ...]
    latencies: tuple[float, ...]
    tuned: Tuned


@dataclass(frozen=True, slots=True)
class TrialRow:
    """Outcome of one closing. Times are in s, forces in N."""

    kind: str
    session: int
    variant: str
    latency: float
    peak: float
    squeeze: float
    time: float | None
    dropped: bool
    broken: bool
    misses: int

    @property
    def shore_a(self) -> float:
        """Shore A of the object."""
        return KINDS[self.kind].shore_a


def run_trial(trial: Trial, model: fc.Model | None = None) -> list[TrialRow]:
    """Return the outcome of each variant at each latency, ordered by latency, then by variant."""
    rows, setup = [], trial.setup
    for latency, variant in product(trial.latencies, trial.variants):
        plant = trial_plant(setup, variant, latency)
        misses = close_on(plant, setup, variant, trial.tuned, model).counts.misses
        outcome = plant.outcome
        row = TrialRow(
            kind=setup.kind,
            session=setup.session,
            variant=variant.key,
            latency=latency,
            peak=outcome.peak_force,
            squeeze=outcome.squeeze,
            time=outcome.time_to_grasp,
            dropped=outcome.dropped,
            broken=outcome.broken,
            misses=misses,
        )
        rows.append(row)
    return rows


def search(settings: GraspStudySettings, runner: Runner) -> dict[str, Tuning]:
    """Choose the settings of every variant that has settings to tune, on other pinches."""
    lasting = tuple(k for k in settings.kinds if KINDS[k].fragility is None)
    numbers = range(settings.tuning)
    wide = tuple(PinchSetup(k, s, "search", settings.seed) for k in lasting for s in numbers)
    short = tuple(PinchSetup(k, s, "search", settings.seed) for k in FIRST_ROUND for s in range(2))
    tuned = {key: v for key, v in variants().items() if v.policy.tunables}
    usual = runner.map(_closings, [(unmodulated(), {}, setups) for setups in (short, wide)])
    tunings = {}
    rounds = {key: _candidates(v.policy) for key, v in tuned.items()}
    counts = {key: len(tried) for key, tried in rounds.items()}
    for setups, usual_rows in zip((short, wide), usual, strict=True):
        limit = _summary(usual_rows)[1] * (1 + SLOWER)
        jobs = [(tuned[k], c, setups) for k, tried in rounds.items() for c in tried]
        outcomes = iter(runner.map(_closings, jobs))
        for key, tried in rounds.items():
            scored = [(_worth(_summary(next(outcomes)), limit), c) for c in tried]
            scored.sort(key=lambda pair: pair[0])
            rounds[key] = [c for _, c in scored[:FINALISTS]]
            (_, peak, time, unsteady), best = scored[0]
            tunings[key] = Tuning(
                settings=best, tried=counts[key], peak=peak, time=time, unsteady=unsteady
            )
    return tunings


def _candidates(policy: type[Policy]) -> list[dict[str, float]]:
    """Return every combination of the few values of all settings."""
    values = (t.few for t in policy.tunables.values())
    return [dict(zip(policy.tunables, chosen, strict=True)) for chosen in product(*values)]


def _closings(job: tuple[Variant, Mapping[str, float], tuple[PinchSetup, ...]]) -> list[TrialRow]:
    variant, settings, setups = job
    trials = (Trial(s, (variant,), (HEADLINE,), {variant.key: settings}) for s in setups)
    return [row for trial in trials for row in run_trial(trial)]


def _summary(rows: list[TrialRow]) -> tuple[float, float, float]:
    """Return mean peak force on soft objects, N, mean time, s, and share of unsteady grasps."""
    soft = [r.peak for r in rows if r.shore_a <= SOFT]
    times = [r.time for r in rows if r.time is not None]
    unsteady = sum(r.time is None or r.dropped for r in rows) / len(rows)
    return float(np.mean(soft)), float(np.mean(times)) if times else 1.0, unsteady


def _worth(summary: tuple[float, float, float], limit: float) -> tuple[float, float, float, float]:
    """Return a sort key: excess over the limits, peak force, time, share of unsteady grasps."""
    peak, time, unsteady = summary
    return (unsteady + max(time / limit - 1, 0.0), peak, time, unsteady)


def _breaks(row: TrialRow) -> bool:
    return KINDS[row.kind].fragility is not None


#: Groups of objects whose closings are summarised together. Brittle objects are apart, because the
#: peak force on an object that broke is only its breaking force.
GROUPS: Mapping[str, Callable[[TrialRow], bool]] = {
    "soft": lambda row: not _breaks(row) and row.shore_a <= SOFT,
    "firm": lambda row: not _breaks(row) and row.shore_a > SOFT,
    "lasting": lambda row: not _breaks(row),
    "brittle": _breaks,
    "all": lambda row: True,
}


def summary(rows: Sequence[TrialRow], seed: int) -> Summary:
    """Return means and shares of outcomes over closings."""
    steady = np.array([r.time is not None for r in rows], dtype=float)
    columns = np.stack(
        [
            np.ones(len(rows)),
            [r.peak for r in rows],
            [1e3 * r.squeeze for r in rows],
            [1e3 * (r.time or 0.0) for r in rows],
            steady,
            [r.dropped for r in rows],
            [r.broken for r in rows],
        ],
        axis=1,
    )
    means: dict[str, Callable[[Values], Values]] = {
        "peak_n": lambda s: s[..., 1] / s[..., 0],
        "squeeze_mm": lambda s: s[..., 2] / s[..., 0],
        "steady": lambda s: s[..., 4] / s[..., 0],
        "dropped": lambda s: s[..., 5] / s[..., 0],
        "broken": lambda s: s[..., 6] / s[..., 0],
    }
    if steady.any():
        # A resample without a steady grasp has no mean time: use that of all closings.
        mean_time = columns[:, 3].sum() / steady.sum()
        means["time_ms"] = lambda s: np.where(
            s[..., 4] > 0, s[..., 3] / np.maximum(s[..., 4], 1), mean_time
        )
    sessions = np.array([r.session for r in rows])
    total = columns.sum(axis=0)
    return Summary(
        **{name: float(of(total)) for name, of in means.items()},
        n=len(rows),
        misses=sum(r.misses for r in rows),
        intervals=cluster_intervals(columns, means, sessions, seed),
    )


def by_policy(rows: Sequence[TrialRow], seed: int) -> Policies:
    """Return the :func:`summary` of each variant, latency (ms) and group of objects."""
    policies: Policies = {}
    for variant, latency in dict.fromkeys((r.variant, r.latency) for r in rows):
        selected = [r for r in rows if r.variant == variant and r.latency == latency]
        groups = {name: [r for r in selected if belongs(r)] for name, belongs in GROUPS.items()}
        policies.setdefault(variant, {})[f"{1e3 * latency:g}"] = {
            name: summary(group, seed) for name, group in groups.items() if group
        }
    return policies
