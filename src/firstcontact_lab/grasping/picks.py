"""Simulated picks of household objects, either up to the second contact or up to the lift."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from firstcontact.core import Block, Command, Estimate
from firstcontact.grasp import POLICIES, Grip, Policy
from firstcontact.grasp.household_policies import ByStiffness, FinalForce
from firstcontact.grasp.policy import Truth
from firstcontact.grasp.registry import make_policy
from firstcontact.streaming import ContactEvent, ContactWithdrawn, Pipeline
from firstcontact.streaming.grasping import Grasping
from firstcontact.twin import TwinObject, draw_pinch
from firstcontact.twin.draw import condition
from firstcontact.twin.drive import Drive
from firstcontact.twin.household import draw_household_specimen, household_named
from firstcontact.twin.outcome import Lift
from firstcontact.twin.plant import GraspPlant
from firstcontact_lab.grasping.hands import (
    BLOCK,
    CONDITION,
    LAYOUT,
    AdaptedHand,
    AdaptedHands,
    PlantHand,
    SlipWatch,
)

#: Longest closing, with the slowest lift, s.
LONGEST_PICK = 2.0
LIFTS = {"abrupt": Lift(), "gradual": Lift(duration=1.0)}
#: Number of samples between two checks for a slip.
SLIP_STEP = 10


@dataclass(frozen=True, slots=True, order=True)
class Pick:
    kind: str
    hand: int
    specimen: int


def pick_specimen(pick: Pick) -> TwinObject:
    kind = household_named(pick.kind)
    return draw_household_specimen(pick.hand, condition(CONDITION), kind, pick.specimen)


def make_plant(pick: Pick, breaks: bool = True, lift: Lift | None = None) -> GraspPlant:
    specimen = pick_specimen(pick)
    rig = condition(CONDITION)
    draw = draw_pinch(pick.hand, rig, f"household-{pick.specimen}", specimen, pick.kind)
    target = specimen if breaks else replace(specimen, fragility=None)
    return GraspPlant(draw, Drive(), target, lift=lift, longest=LONGEST_PICK)


def make_pipeline(hand: AdaptedHand) -> Pipeline:
    return Pipeline(LAYOUT, hand.detector, hand.model, clock=lambda: 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class ApproachState:
    """State of a simulated hand at the second contact, with the live estimates until then."""

    plant: GraspPlant
    estimate: Estimate | None
    answers: tuple[Estimate, ...]
    heard: float | None
    offset: float | None


class _WaitingHand(PlantHand):
    """Simulated hand that obeys commands until both fingers touch, and ignores them afterwards."""

    def __init__(self, plant: GraspPlant, policy: ByStiffness) -> None:
        super().__init__(plant)
        self._policy = policy

    def send(self, command: Command) -> None:
        if not self._policy.both:
            super().send(command)


def simulate_approach(pick: Pick, speed: float, hand: AdaptedHand) -> ApproachState:
    """Simulate a hand that closes on an unbreakable object, until both fingers touch.

    ``speed`` is the approach speed, m/s.
    """
    plant = make_plant(pick, breaks=False)
    policy = ByStiffness(Grip(), approach=speed)
    grasping = Grasping(policy, _WaitingHand(plant, policy), LAYOUT)
    pipeline = make_pipeline(hand)
    answers: list[Estimate] = []
    first: float | None = None
    heard: float | None = None
    while not policy.both and not plant.ended:
        start = plant.sample
        block = Block(plant.advance(BLOCK), start)
        grasping.on_samples(block, 0.0)
        for event in pipeline.update(block, 0.0):
            match event:
                case Estimate() if event.final:
                    answers = [a for a in answers if a.elapsed <= event.elapsed]
                case Estimate():
                    answers.append(event)
                case ContactEvent() if event.first:
                    first = event.contact.sample / LAYOUT.rate
                case ContactEvent() if heard is None and first is not None:
                    heard = event.contact.decided / LAYOUT.rate - first
                case ContactWithdrawn():
                    answers, first, heard = [], None, None
            grasping.on_event(event)
        grasping.after_block(block)
    one, two = plant.outcome.first_contact, plant.outcome.second_contact
    offset = None if one is None or two is None else two - one
    return ApproachState(plant, policy.estimate, tuple(answers), heard, offset)


@dataclass(frozen=True, slots=True)
class FullPickJob:
    pick: Pick
    policy: str
    settings: Mapping[str, float]
    lift: str = "abrupt"
    detection: float | None = None


@dataclass(frozen=True, slots=True)
class FullPickOutcome:
    """Outcome of one pick, simulated from the open hand to the lifted object.

    ``steady`` is the time to a steady grasp, s; None without one. ``largest`` is the largest
    contact force, N.
    """

    job: FullPickJob
    dropped: bool
    damaged: bool
    steady: float | None
    estimates: int
    largest: float


def household_policy(kind: type[Policy], name: str, settings: Mapping[str, float]) -> FinalForce:
    """Return a policy that knows the true Shore A and mass of the object ``name``.

    ``kind`` is the class of the policy, and ``settings`` are its tuned numbers.
    """
    numbers = household_named(name).numbers
    truth = Truth(numbers.shore_a.value, numbers.mass.value)
    policy = make_policy(kind, Grip(), truth, settings)
    if not isinstance(policy, FinalForce):
        raise TypeError(
            f"{kind.name} is not a policy for household objects: derive it from FinalForce"
        )
    return policy


def simulate_full_closing(job: FullPickJob, hands: AdaptedHands) -> FullPickOutcome:
    """Simulate a whole pick, in which a policy acts on live estimates. Return the outcome."""
    plant = make_plant(job.pick, lift=LIFTS[job.lift])
    policy = household_policy(POLICIES[job.policy], job.pick.kind, job.settings)
    grasping = Grasping(policy, PlantHand(plant), LAYOUT)
    pipeline = make_pipeline(hands[job.pick.hand, job.settings["approach"]])
    watch = None if job.detection is None else SlipWatch(job.detection)
    while not plant.ended:
        start = plant.sample
        listening = not policy.both
        block = Block(plant.advance(BLOCK if listening else SLIP_STEP), start)
        if listening:
            grasping.on_samples(block, 0.0)
            for event in pipeline.update(block, 0.0):
                grasping.on_event(event)
        grasping.after_block(block)
        if watch is not None and watch.slips(plant):
            grasping.loop.slipped(plant.now)
    outcome = plant.outcome
    return FullPickOutcome(
        job,
        outcome.dropped,
        outcome.broken,
        outcome.time_to_grasp,
        grasping.loop.counts.estimates,
        float(plant.forces.max()),
    )
