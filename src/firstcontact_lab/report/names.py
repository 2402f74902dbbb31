"""What results call estimators and detectors, as people read it: out of the registries."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass
from typing import Any

from firstcontact.contact import DETECTORS
from firstcontact.core import SKY, Registry
from firstcontact.models import ESTIMATORS

#: Keys in results, and how splits are called.
SPLITS = {
    "random_90_10": "random 90/10",
    "by_session": "by session",
    "leave_one_shore_out": "level left out",
}


@dataclass(frozen=True, slots=True)
class Look:
    """Title and colour of an estimator or a detector."""

    title: str
    colour: str


def estimator(name: str) -> Look:
    """Of an estimator; its name where none of that name is installed (any more)."""
    return _look(ESTIMATORS, name)


def detector(name: str) -> Look:
    """Of a detector, likewise."""
    return _look(DETECTORS, name)


def _look(registry: Registry[Any], name: str) -> Look:
    entry = registry.get(name)
    return Look(name, SKY) if entry is None else Look(entry.title, entry.colour)


def estimators(found: Container[str], baselines: bool = False) -> list[str]:
    """Names of those in some results, floors only if wanted, in the order of reports."""
    return [n for n in ESTIMATORS.names if n in found and (baselines or not is_floor(n))]


def is_floor(name: str) -> bool:
    """Whether an estimator is a floor to stand on."""
    return name in ESTIMATORS and ESTIMATORS[name].baseline


def detectors(found: Container[str]) -> list[str]:
    """Names of those in some results, in the order of reports."""
    return [name for name in DETECTORS.names if name in found]


def learned(detector_name: str | None) -> bool:
    """Whether what places windows is a detector that learns."""
    return detector_name in DETECTORS and DETECTORS[str(detector_name)].learns
