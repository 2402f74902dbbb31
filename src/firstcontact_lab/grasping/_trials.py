"""Trials of the payload task: every variant closes on the same object, with one row each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from firstcontact.grasp import Grip
from firstcontact.models import Model
from firstcontact.streaming import Pipeline, WindowLadder
from firstcontact.twin import Drive, GraspPlant, condition, draw_pinch, draw_specimen
from firstcontact_lab.grasping._closing import LAYOUT, ClosingRecord, close
from firstcontact_lab.grasping._learning import CONDITION
from firstcontact_lab.grasping._variants import Variant
from firstcontact_lab.grasping.settings import KINDS

#: Tuned settings of the policy of each variant, by the key of the variant.
Tuned = Mapping[str, Mapping[str, float]]


@dataclass(frozen=True, slots=True)
class PinchSetup:
    """Object and session of a random pinch."""

    kind: str
    session: int
    group: str = "grasp"
    seed: int = 0


@dataclass(frozen=True, slots=True)
class Row:
    """Outcome of one closing. Times are in s, forces in N."""

    kind: str
    shore_a: float
    session: int
    variant: str
    latency: float
    peak: float
    squeeze: float
    time: float | None
    slipped: float
    dropped: bool
    broken: bool
    touched: float | None
    offset: float | None
    estimate: float | None
    misses: int
    estimates: int


def trial_plant(setup: PinchSetup, variant: Variant, latency: float) -> GraspPlant:
    """Return the hand before closing. The random draws are the same for all policies."""
    rig = condition(CONDITION)
    # Each session has another specimen. The first specimens are left out: models were trained on
    # them.
    specimen = draw_specimen(setup.seed, rig, KINDS[setup.kind], 1 + _specimen(setup))
    draw = draw_pinch(setup.seed, rig, f"{setup.group}-{setup.session}", specimen, setup.kind)
    return GraspPlant(draw, Drive(latency=latency), specimen, variant.velostat)


def _specimen(setup: PinchSetup) -> int:
    return 2 * setup.session + (setup.group == "grasp")


def played(
    plant: GraspPlant,
    setup: PinchSetup,
    variant: Variant,
    tuned: Tuned,
    model: Model | None,
) -> ClosingRecord:
    """Simulate a closing on the object of the setup, with the policy of the variant."""
    # The policy knows the drawn approach speed.
    grip = Grip(speed=plant.nominal.speed, force=plant.nominal.force)
    policy = variant.make(grip, KINDS[setup.kind].shore_a, tuned.get(variant.key, {}))
    feels = policy.uses_force()
    if not policy.uses_piezos() or model is None:
        return close(plant, policy, feels=feels)
    wanted = model.windows if policy.deadline is not None else ()
    predictor = WindowLadder(wanted) if wanted else None
    pipeline = Pipeline(LAYOUT, model.own_detector, predictor, clock=lambda: 0.0)
    return close(plant, policy, pipeline, len(wanted), feels)


@dataclass(frozen=True, slots=True)
class Trial:
    """Job that closes the hand on one setup, with all variants at all latencies of the drive."""

    setup: PinchSetup
    variants: tuple[Variant, ...]
    latencies: tuple[float, ...]
    tuned: Tuned


def run_trial(trial: Trial, model: Model | None = None) -> list[Row]:
    """Return the outcome of each variant at each latency, ordered by latency, then by variant."""
    return [
        _row(trial, model, variant, latency)
        for latency in trial.latencies
        for variant in trial.variants
    ]


def _row(trial: Trial, model: Model | None, variant: Variant, latency: float) -> Row:
    setup = trial.setup
    plant = trial_plant(setup, variant, latency)
    closing = played(plant, setup, variant, trial.tuned, model)
    outcome = plant.outcome
    both = outcome.first_contact is not None and outcome.second_contact is not None
    last = closing.estimates[-1].value if closing.estimates else None
    return Row(
        kind=setup.kind,
        shore_a=KINDS[setup.kind].shore_a,
        session=setup.session,
        variant=variant.key,
        latency=latency,
        peak=outcome.peak_force,
        squeeze=outcome.squeeze,
        time=outcome.time_to_grasp,
        slipped=outcome.slipped,
        dropped=outcome.dropped,
        broken=outcome.broken,
        touched=outcome.first_contact,
        offset=(outcome.second_contact or 0.0) - (outcome.first_contact or 0.0) if both else None,
        estimate=last,
        misses=closing.counts.misses,
        estimates=closing.counts.estimates,
    )
