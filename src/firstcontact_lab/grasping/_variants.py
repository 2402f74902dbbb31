"""Variants in the payload task: each policy with taxels that have errors, or with ideal ones."""

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
    """Policy with one kind of taxels: with random errors, or ideal."""

    key: str
    title: str
    colour: str
    policy: type[Policy]
    velostat: VelostatParameters | None = None

    def make(self, grip: Grip, shore_a: float, settings: Mapping[str, float]) -> Policy:
        """Return the tuned policy for one pinch."""
        return make_policy(self.policy, grip, Truth(shore_a), settings)


def variants() -> dict[str, Variant]:
    """Return the variants by key: each policy of the payload task, with each kind of taxels."""
    by_key: dict[str, Variant] = {}
    for policy in POLICIES.values():
        if policy.task is not Task.PAYLOAD:
            continue
        as_it_is = SensorVariant(policy.name, policy.title, policy.colour)
        for sensor_variant in policy.variants or (as_it_is,):
            if sensor_variant.key in by_key:
                _log.warning(
                    "policy %s of %s is left out, because another policy has this name",
                    sensor_variant.key,
                    policy.name,
                )
                continue
            velostat = _VELOSTAT[sensor_variant.force_array]
            by_key[sensor_variant.key] = Variant(
                sensor_variant.key, sensor_variant.title, sensor_variant.colour, policy, velostat
            )
    return by_key


def playing(part: Part) -> list[Variant]:
    """Return the variants whose policies have this role in the comparison."""
    return [variant for variant in variants().values() if variant.policy.part is part]


def unmodulated() -> Variant:
    """Return the variant that does not adapt its force, with which the others are compared."""
    return playing(Part.UNMODULATED)[0]
