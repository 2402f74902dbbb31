"""Simulation of a pick with every grip force. All grip forces share one approach."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FINGERTIP_RATE, GRAVITY, Command, Estimate
from firstcontact.grasp import Grip
from firstcontact.twin import (
    GraspPlant,
    Lift,
)
from firstcontact_lab.grasping._approach import Pick, approached, pick_specimen
from firstcontact_lab.grasping._own_hand import OwnHand
from firstcontact_lab.grasping._slip import SlipWatch

Values = NDArray[np.float64]

#: Kinds of lift, by name.
LIFTS = {"abrupt": Lift(), "gradual": Lift(duration=1.0)}
#: Assumed latencies of the slip detection, s.
DETECTION = (0.100, 0.300)
#: Number of samples to simulate at a time when no policy reads them.
LOT = 100


@dataclass(frozen=True, slots=True)
class Branching:
    """Speeds and forces that are simulated, in all combinations, for the table of closings."""

    speeds: tuple[float, ...]
    forces: tuple[float, ...]
    boosts: tuple[float, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Branches:
    """Outcomes of one pick at one approach speed, for each grip force."""

    pick: Pick
    speed: float
    mass: float
    friction: float
    limit: float
    estimate: Estimate | None
    answers: tuple[Estimate, ...]
    heard: float | None
    peak: Values
    hold: Values
    slip_peak: Values
    slip_drop: Values


def branches(
    job: tuple[Pick, float], hands: dict[tuple[int, float], OwnHand], how: Branching
) -> Branches:
    """Simulate one approach, then a grip with each force and the lift of the object."""
    pick, speed = job
    specimen = pick_specimen(pick)
    begun = approached(pick, speed, hands[pick.hand, speed])
    shape = (len(LIFTS), len(DETECTION), len(how.boosts), len(how.forces))
    peak, hold = np.empty(len(how.forces)), np.empty(len(how.forces))
    slip_peak, slip_drop = np.full(shape, np.nan), np.full(shape, np.nan)
    for place, force in enumerate(how.forces):
        plant = begun.plant.copy()
        plant.command(Grip().pressing(force))
        _until(plant, Lift().delay)
        lifted = plant.copy()
        _until(lifted, np.inf)
        forces = lifted.forces
        peak[place], hold[place] = forces.max(), forces[-1].sum()
        if specimen.friction * hold[place] >= specimen.mass * GRAVITY:
            continue
        for (a, lift), (b, wait), (c, boost) in product(
            enumerate(LIFTS.values()), enumerate(DETECTION), enumerate(how.boosts)
        ):
            again = plant.copy(lift)
            slip_peak[a, b, c, place], slip_drop[a, b, c, place] = _reflex(
                again, force, wait, boost, speed
            )
    return Branches(
        pick, speed, specimen.mass, specimen.friction,
        np.inf if specimen.fragility is None else specimen.fragility.scale,
        begun.estimate, begun.answers, begun.heard,
        peak, hold, slip_peak, slip_drop,
    )  # fmt: skip


def _until(plant: GraspPlant, since: float) -> None:
    """Advance the plant to ``since`` s after the first contact, or to the end of the closing."""
    contacts = plant.contacts
    end = contacts[0].sample + since * FINGERTIP_RATE if contacts else np.inf
    while not plant.ended and plant.sample < end:
        plant.move(int(min(LOT, max(end - plant.sample, 1))))


def _reflex(
    plant: GraspPlant, force: float, wait: float, boost: float, speed: float
) -> tuple[float, bool]:
    """Lift with a slip reflex. Return the largest contact force, N, and True for a drop."""
    watch = SlipWatch(wait)
    while not plant.ended and not plant.lost:
        plant.move(10)
        if watch.slips(plant):
            force = min(force * boost, Grip().force)
            pressing = Grip().pressing(force)
            plant.command(Command(max(pressing.speed, speed), pressing.force))
    return float(plant.forces.max()), plant.lost or plant.outcome.dropped
