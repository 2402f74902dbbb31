"""What is compared: a policy and the force array it feels with."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass

from firstcontact.grasp import (
    POLICIES,
    ForceArray,
    Grip,
    Part,
    Policy,
    SensorVariant,
    Task,
    Truth,
    make_policy,
)
from firstcontact.twin import OPTIMISTIC, VelostatParameters

_log = logging.getLogger(__name__)

_VELOSTAT: Mapping[ForceArray, VelostatParameters | None] = {
    ForceArray.DRAWN: None,
    ForceArray.IDEAL: OPTIMISTIC,
}


@dataclass(frozen=True, slots=True)
class Variant:
    """One way of closing.

    Parameters
    ----------
    key
        In tables and files.
    title, colour
        As readers see it, and of its bars and lines.
    policy
        What decides.
    velostat
        The force array of both fingers; None for the twin's own, drawn for each pinch.
    """

    key: str
    title: str
    colour: str
    policy: type[Policy]
    velostat: VelostatParameters | None = None

    def make(self, grip: Grip, shore_a: float, settings: Mapping[str, float]) -> Policy:
        """A policy for one pinch, as it was tuned."""
        return make_policy(self.policy, grip, Truth(shore_a), settings)


def variants() -> dict[str, Variant]:
    """What is compared, by key: policies for a payload, with each sensor they are tried with."""
    found: dict[str, Variant] = {}
    for policy in POLICIES.values():
        if policy.task is not Task.PAYLOAD:
            continue
        as_it_is = SensorVariant(policy.name, policy.title, policy.colour)
        for its in policy.variants or (as_it_is,):
            if its.key in found:
                _log.warning("%s of %s left out: the name is taken", its.key, policy.name)
                continue
            velostat = _VELOSTAT[its.force_array]
            found[its.key] = Variant(its.key, its.title, its.colour, policy, velostat)
    return found


def playing(part: Part) -> list[Variant]:
    """Those that play this part in the comparison."""
    return [variant for variant in variants().values() if variant.policy.part is part]


def unmodulated() -> Variant:
    """What all others are shown beside."""
    return playing(Part.UNMODULATED)[0]
