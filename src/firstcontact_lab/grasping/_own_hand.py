"""Detector and model of a simulated hand, from its own block pinches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import Detector
from firstcontact.core import Command, Dataset, Label, Pinch, Serial
from firstcontact.grasp import Grip
from firstcontact.models import (
    InContextModel,
    adapt_combined,
    choose_detector,
    cut_touches,
    pretrained,
)
from firstcontact.twin import BLOCKS, Drive, GraspPlant, condition, draw_pinch, draw_specimen
from firstcontact_lab.grasping._closing import LAYOUT

#: Condition of the twin.
CONDITION = "paper-rig"
#: Time after the first contact with a block at which its closing ends, s; longer than any window.
AFTER = 0.060


@dataclass(frozen=True, slots=True, eq=False)
class OwnHand:
    """Detector and model of one hand, from its block pinches."""

    detector: Detector
    model: InContextModel
    pinches: int
    rmse: float


@dataclass(frozen=True, slots=True)
class HandSeed:
    """Seed of a random hand, and its approach speed, m/s."""

    seed: int
    speed: float


def own_hand(hand: HandSeed, pinches: int) -> OwnHand:
    """Close a hand ``pinches`` times on each of the five blocks, and adapt to it."""
    made = [_block(hand, place, n) for place in range(len(BLOCKS)) for n in range(pinches)]
    dataset = Dataset(tuple(made), "twin")
    detector, contacts, _ = choose_detector(
        dataset, name=None, is_known=False, seed=hand.seed, runner=Serial()
    )
    touches, indices = cut_touches(dataset, contacts.contacts)
    adapted = adapt_combined(
        pretrained(), touches, dataset.shore_a[indices], dataset.sessions[indices], hand.seed
    )
    return OwnHand(detector, adapted.model, len(indices), adapted.rmse)


def _block(hand: HandSeed, place: int, number: int) -> Pinch:
    """Return one closing on block ``place``. It ends ``AFTER`` s after the first contact."""
    rig = condition(CONDITION)
    specimen = draw_specimen(hand.seed, rig, BLOCKS[place], 0)
    session = f"blocks-{number % 3}"
    draw = draw_pinch(hand.seed, rig, session, specimen, (specimen.name, number))
    plant = GraspPlant(draw, Drive(), specimen)
    plant.command(Command(hand.speed, Grip().searching))
    data: list[NDArray[np.int16]] = []
    end: int | None = None
    while not plant.ended and (end is None or plant.sample < end):
        data.append(plant.advance(50))
        if end is None and plant.contacts:
            end = plant.contacts[0].sample + round(AFTER * LAYOUT.rate)
    label = Label(specimen.name, specimen.shore_a, specimen=specimen.name, session=session)
    return Pinch(np.concatenate(data), LAYOUT, label, 0, plant.contacts)
