"""Simulated hands for the grasp study, each with its own trained detector and model."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact import Detector
from firstcontact.core import Command, Dataset, Label, Pinch, fingertip_layout
from firstcontact.grasp import Grip, Hand, HandLimits
from firstcontact.jobs import Serial
from firstcontact.models import Touches
from firstcontact.models.alignment import choose_detector
from firstcontact.models.model_file import pretrained
from firstcontact.models.rig.combined import adapt_combined
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.twin import BLOCKS, draw_pinch
from firstcontact.twin.draw import condition, draw_specimen
from firstcontact.twin.drive import Drive
from firstcontact.twin.plant import GraspPlant

LAYOUT = fingertip_layout()
#: Number of samples of a block, as the device sends them.
BLOCK = 5
#: Condition of the twin. It names the sessions of training pinches "blocks-01" and so on.
CONDITION = "paper-rig"
#: Time after the first contact with a block at which its closing ends, s; longer than any window.
AFTER = 0.060


class PlantHand(Hand):
    name = "plant"
    limits = HandLimits(speed=0.25, force=12.0, rate=math.inf, watchdog=math.inf)

    def __init__(self, plant: GraspPlant) -> None:
        self._plant = plant

    def send(self, command: Command) -> None:
        self._plant.command(command)

    def release(self) -> None:
        self.send(Command(-self.limits.speed, 0.0))

    def close(self) -> None:
        """Do nothing, because a simulated hand has no connection to close."""


class SlipWatch:
    """Ideal slip detector of a simulated hand. It reports every true slip after ``latency`` s."""

    def __init__(self, latency: float) -> None:
        self._latency = latency
        self._reported = -math.inf

    def slips(self, plant: GraspPlant) -> bool:
        since = plant.slipping_since
        if since is None or plant.now - max(since, self._reported) < self._latency:
            return False
        self._reported = plant.now
        return True


@dataclass(frozen=True, slots=True, eq=False)
class AdaptedHand:
    detector: Detector
    model: RigModel
    pinches: int
    rmse: float


#: Seed of a random hand, and its approach speed, m/s.
HandSeed = tuple[int, float]
AdaptedHands = dict[HandSeed, AdaptedHand]


def adapt_to_hand(hand: HandSeed, pinches: int) -> AdaptedHand:
    """Adapt a contact detector and a model to a simulated hand, and return both.

    ``hand`` is (seed, approach speed in m/s). The training data are ``pinches`` simulated closings
    on each of 5 blocks.
    """
    seed, speed = hand
    made = [_block(seed, speed, at, n) for at in range(len(BLOCKS)) for n in range(pinches)]
    dataset = Dataset(tuple(made), "twin")
    detector, contacts, _ = choose_detector(
        dataset, name=None, is_known=False, seed=seed, runner=Serial()
    )
    touches, indices = Touches.cut(dataset, contacts.contacts)
    adapted = adapt_combined(
        pretrained(), touches, dataset.shore_a[indices], dataset.sessions[indices], seed
    )
    return AdaptedHand(detector, adapted.model, len(indices), adapted.rmse)


def _block(seed: int, speed: float, place: int, number: int) -> Pinch:
    """Simulate closing ``number`` on the block with the index ``place`` in ``BLOCKS``.

    ``speed`` is the closing speed, m/s. The closing ends ``AFTER`` s after the contact.
    """
    rig = condition(CONDITION)
    specimen = draw_specimen(seed, rig, BLOCKS[place], 0)
    session = f"blocks-{number % 3}"
    draw = draw_pinch(seed, rig, session, specimen, (specimen.name, number))
    plant = GraspPlant(draw, Drive(), specimen)
    plant.command(Command(speed, Grip().searching))
    data: list[NDArray[np.int16]] = []
    end = math.inf
    while not plant.ended and plant.sample < end:
        data.append(plant.advance(50))
        if end == math.inf and plant.contacts:
            end = plant.contacts[0].sample + round(AFTER * LAYOUT.rate)
    label = Label(specimen.name, specimen.shore_a, specimen=specimen.name, session=session)
    return Pinch(np.concatenate(data), LAYOUT, label, 0, plant.contacts)
