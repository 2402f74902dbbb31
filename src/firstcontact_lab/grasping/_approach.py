"""Approach of a closing on a household object, until both fingers touch."""

from __future__ import annotations

from dataclasses import dataclass, replace

from firstcontact.core import Block, Command, Estimate
from firstcontact.grasp import ByStiffness, Grip
from firstcontact.streaming import (
    AnytimePredictor,
    ContactEvent,
    ContactWithdrawn,
    Grasping,
    Pipeline,
)
from firstcontact.twin import (
    Drive,
    GraspPlant,
    Lift,
    TwinObject,
    condition,
    draw_household_specimen,
    draw_pinch,
    household_named,
)
from firstcontact_lab.grasping._closing import BLOCK, LAYOUT, PlantHand
from firstcontact_lab.grasping._own_hand import CONDITION, OwnHand

#: Longest closing, with the slowest lift, s.
LONGEST = 2.0


@dataclass(frozen=True, slots=True, order=True)
class Pick:
    """One attempt of a hand to pick up an object."""

    kind: str
    hand: int
    specimen: int


@dataclass(frozen=True, slots=True, eq=False)
class Approached:
    """State of a closing at the moment at which both fingers touch."""

    plant: GraspPlant
    estimate: Estimate | None
    answers: tuple[Estimate, ...]
    heard: float | None
    offset: float | None


def pick_specimen(pick: Pick) -> TwinObject:
    """Return the specimen of a pick, with its mass, friction and breaking force."""
    specimen = household_named(pick.kind)
    return draw_household_specimen(pick.hand, condition(CONDITION), specimen, pick.specimen)


def make_plant(pick: Pick, breaks: bool = True, lift: Lift | None = None) -> GraspPlant:
    """Return the simulated hand, ready to close on the object of a pick."""
    specimen = pick_specimen(pick)
    rig = condition(CONDITION)
    draw = draw_pinch(pick.hand, rig, f"household-{pick.specimen}", specimen, pick.kind)
    object = specimen if breaks else replace(specimen, fragility=None)
    return GraspPlant(draw, Drive(), object, lift=lift, longest=LONGEST)


class _Waiting(PlantHand):
    """Hand that passes commands on to the plant until both fingers touch, and then ignores them."""

    def __init__(self, plant: GraspPlant, policy: ByStiffness) -> None:
        super().__init__(plant)
        self._policy = policy

    def send(self, command: Command) -> None:
        if not self._policy.both:
            super().send(command)


def approached(pick: Pick, speed: float, hands: OwnHand, breaks: bool = False) -> Approached:
    """Simulate the approach to an object until both fingers touch."""
    plant = make_plant(pick, breaks)
    policy = ByStiffness(Grip(), approach=speed)
    hand = _Waiting(plant, policy)
    grasping = Grasping(policy, hand, LAYOUT)
    predictor = AnytimePredictor(hands.model)
    pipeline = Pipeline(LAYOUT, hands.detector, predictor, clock=lambda: 0.0)
    answers: list[Estimate] = []
    first: float | None = None
    heard: float | None = None
    while not policy.both and not plant.ended:
        start = plant.sample
        block = Block(plant.advance(BLOCK), start)
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
    outcome = plant.outcome
    both = outcome.first_contact is not None and outcome.second_contact is not None
    offset = (outcome.second_contact or 0.0) - (outcome.first_contact or 0.0) if both else None
    return Approached(plant, policy.estimate, tuple(answers), heard, offset)
