"""Simulation of a full closing: plant, detector, model, grasp loop with deadline, and slips."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block
from firstcontact.grasp import POLICIES, FinalForce, Grip, Truth, make_policy
from firstcontact.streaming import AnytimePredictor, Grasping, Pipeline
from firstcontact.twin import GraspPlant, household_named
from firstcontact_lab.grasping._approach import Pick, make_plant
from firstcontact_lab.grasping._branches import LIFTS
from firstcontact_lab.grasping._closing import BLOCK, LAYOUT, Order, PlantHand
from firstcontact_lab.grasping._own_hand import OwnHand
from firstcontact_lab.grasping._slip import SlipWatch

#: Number of samples between two checks for a slip.
LOOK = 10


@dataclass(frozen=True, slots=True)
class RealJob:
    """Full closing to simulate: pick, policy with its settings, lift and slip detector."""

    pick: Pick
    policy: str
    settings: Mapping[str, float]
    lift: str = "abrupt"
    detection: float | None = None


@dataclass(frozen=True, slots=True)
class RealRow:
    """Outcome of a full closing. ``steady``: time to a steady grasp, s; None if there is none."""

    job: RealJob
    dropped: bool
    damaged: bool
    steady: float | None
    estimates: int


@dataclass(frozen=True, slots=True, eq=False)
class Played:
    """Course of a full closing: state of the plant at its end, commands, forces (N), outcome."""

    plant: GraspPlant
    orders: tuple[Order, ...]
    forces: NDArray[np.float64]
    row: RealRow


def real(job: RealJob, hands: Mapping[tuple[int, float], OwnHand]) -> RealRow:
    """Simulate a full closing, and return its outcome."""
    return played(job, hands).row


def played(job: RealJob, hands: Mapping[tuple[int, float], OwnHand]) -> Played:
    """Simulate a full closing, and return its whole course for plots."""
    own_hand = hands[job.pick.hand, job.settings["approach"]]
    plant = make_plant(job.pick, lift=LIFTS[job.lift])
    numbers = household_named(job.pick.kind).numbers
    truth = Truth(numbers.shore_a.value, numbers.mass.value)
    policy = make_policy(POLICIES[job.policy], Grip(), truth, job.settings)
    if not isinstance(policy, FinalForce):
        raise TypeError(f"{job.policy} is not a policy for household objects: use a FinalForce")
    hand = PlantHand(plant)
    grasping = Grasping(policy, hand, LAYOUT)
    predictor = AnytimePredictor(own_hand.model)
    pipeline = Pipeline(LAYOUT, own_hand.detector, predictor, clock=lambda: 0.0)
    watch = None if job.detection is None else SlipWatch(job.detection)
    while not plant.ended:
        start = plant.sample
        listening = not policy.both
        block = Block(plant.advance(BLOCK if listening else LOOK), start)
        if listening:
            for event in pipeline.update(block, 0.0):
                grasping.on_event(event)
        grasping.after_block(block)
        if watch is not None and watch.slips(plant):
            grasping.loop.slipped(plant.now)
    outcome = plant.outcome
    row = RealRow(
        job, outcome.dropped, outcome.broken, outcome.time_to_grasp,
        grasping.loop.counts.estimates,
    )  # fmt: skip
    return Played(plant, tuple(hand.orders), plant.forces, row)
