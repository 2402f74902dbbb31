"""Families of rigs and objects on which networks are tested, but never trained.

Each family differs from the rigs or objects of :mod:`firstcontact.twin._rigs` in its structure, not
only in random numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from firstcontact.twin._rigs import RandomObject, RandomRig, Resonance, Rng, adjusted


@dataclass(frozen=True, slots=True)
class Family:
    """Family of rigs or objects: a change of a random rig, of a random object, or of both.

    Parameters
    ----------
    title
        Title for tables and figures.
    rig, change_object
        Functions that turn a random rig, or a random object, into one of the family.
    """

    title: str
    rig: Callable[[RandomRig, Rng], RandomRig] = lambda rig, rng: rig
    change_object: Callable[[RandomObject, Rng], RandomObject] = lambda target, rng: target


def _linear_pad(rig: RandomRig, rng: Rng) -> RandomRig:
    finger = rig.finger._replace(pad_stiffening=0.0, pad_arm_stiffness=0.0)
    return adjusted(replace(rig, finger=finger), rng)


def _duller_sensor(rig: RandomRig, rng: Rng) -> RandomRig:
    # A second resonance of the board, high and lightly damped, behind a slow buffer amplifier.
    resonance = Resonance(float(rng.uniform(1500, 2300)), 0.02, float(rng.uniform(0.8, 1.5)))
    finger = rig.finger._replace(buffer_cutoff=float(rng.uniform(400, 700)))
    return adjusted(replace(rig, finger=finger, resonance=resonance), rng)


def _silent_motor(rig: RandomRig, rng: Rng) -> RandomRig:
    noise = replace(rig.noise, rotor=0.0, mesh=0.0, friction=2 * rig.noise.friction)
    return replace(rig, noise=noise)


def _slow_closing(rig: RandomRig, rng: Rng) -> RandomRig:
    return adjusted(
        replace(rig, finger=rig.finger._replace(speed=float(rng.uniform(0.02, 0.04)))), rng
    )


def _edge(target: RandomObject, rng: Rng) -> RandomObject:
    radius = float(np.exp(rng.uniform(np.log(1.5e-3), np.log(4e-3))))
    return replace(target, parameters=target.parameters._replace(radius=radius))


def _thin_shell(target: RandomObject, rng: Rng) -> RandomObject:
    bulk = float(rng.uniform(600, 1800))
    parameters = target.parameters._replace(
        bulk_stiffness=bulk, bulk_damping=2.0, radius=float(rng.uniform(0.02, 0.05))
    )
    return replace(target, parameters=parameters)


def _slow_material(target: RandomObject, rng: Rng) -> RandomObject:
    relaxation = float(rng.uniform(0.012, 0.04))
    return replace(target, parameters=target.parameters._replace(arm_relaxation=relaxation))


#: Families held out of all training, by name.
FAMILIES: Mapping[str, Family] = {
    "linear_pad": Family("a pad that does not stiffen", rig=_linear_pad),
    "duller_sensor": Family("a slow buffer and a second board mode", rig=_duller_sensor),
    "silent_motor": Family("a motor without lines", rig=_silent_motor),
    "slow_closing": Family("closing at 20 to 40 mm/s", rig=_slow_closing),
    "edge": Family("edges of 1.5 to 4 mm", change_object=_edge),
    "thin_shell": Family("shells that bend at the contact", change_object=_thin_shell),
    "slow_material": Family("relaxation in 12 to 40 ms", change_object=_slow_material),
}
