"""Families of rigs and things that no network of ours is trained on: what it is judged by.

Each changes the structure of what training draws, not its seed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from firstcontact.twin._rigs import RandomObject, RandomRig, Resonance, Rng, adjusted


@dataclass(frozen=True, slots=True)
class Family:
    """What is changed, and how.

    Parameters
    ----------
    title
        As people read it.
    rig, held
        Make a rig, or a thing, of the family out of a random one.
    """

    title: str
    rig: Callable[[RandomRig, Rng], RandomRig] = lambda rig, rng: rig
    held: Callable[[RandomObject, Rng], RandomObject] = lambda held, rng: held


def _linear_pad(rig: RandomRig, rng: Rng) -> RandomRig:
    finger = rig.finger._replace(pad_stiffening=0.0, pad_arm_stiffness=0.0)
    return adjusted(replace(rig, finger=finger), rng)


def _duller_sensor(rig: RandomRig, rng: Rng) -> RandomRig:
    # A second board mode, high and hardly damped, behind a buffer that is slow.
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


def _edge(held: RandomObject, rng: Rng) -> RandomObject:
    radius = float(np.exp(rng.uniform(np.log(1.5e-3), np.log(4e-3))))
    return replace(held, parameters=held.parameters._replace(radius=radius))


def _thin_shell(held: RandomObject, rng: Rng) -> RandomObject:
    bulk = float(rng.uniform(600, 1800))
    parameters = held.parameters._replace(
        bulk_stiffness=bulk, bulk_damping=2.0, radius=float(rng.uniform(0.02, 0.05))
    )
    return replace(held, parameters=parameters)


def _slow_material(held: RandomObject, rng: Rng) -> RandomObject:
    relaxation = float(rng.uniform(0.012, 0.04))
    return replace(held, parameters=held.parameters._replace(arm_relaxation=relaxation))


#: Held out of all training, by name.
FAMILIES: Mapping[str, Family] = {
    "linear_pad": Family("a pad that does not stiffen", rig=_linear_pad),
    "duller_sensor": Family("a slow buffer and a second board mode", rig=_duller_sensor),
    "silent_motor": Family("a motor without lines", rig=_silent_motor),
    "slow_closing": Family("closing at 20 to 40 mm/s", rig=_slow_closing),
    "edge": Family("edges of 1.5 to 4 mm", held=_edge),
    "thin_shell": Family("shells that bend at a touch", held=_thin_shell),
    "slow_material": Family("relaxation in 12 to 40 ms", held=_slow_material),
}
