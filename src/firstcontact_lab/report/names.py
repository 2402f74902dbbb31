"""Titles and colours of estimators and detectors in reports."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from firstcontact.contact import DETECTORS
from firstcontact.core import Registry
from firstcontact.core.display import GREEN, SKY
from firstcontact.models import ESTIMATORS

#: Keys in results, with the titles of the splits.
SPLITS = {
    "random_90_10": "random 90/10",
    "by_session": "by session",
    "leave_one_shore_out": "level left out",
}


@dataclass(frozen=True, slots=True)
class Appearance:
    title: str
    colour: str


#: Titles of the network, which has no registry entry.
NETWORK_TITLES: Mapping[str, str] = {
    "in_context": "In-context network",
    "in_context_radius": "In-context network, radius given",
}
NETWORK_COLOUR = GREEN
TITLES: Mapping[str, str] = {
    **NETWORK_TITLES,
    "masked": "Default estimator, masked",
    "modulus": "Knows the modulus",
    "contact_stiffness": "Knows the contact's stiffness",
    "floor": "Trained on these kinds",
}


def competitor_title(name: str) -> str:
    return TITLES.get(name) or estimator(name).title


def estimator(name: str) -> Appearance:
    """Return the title and colour of an estimator in reports.

    For an estimator that is not installed, ``name`` is the title.
    """
    return _appearance(ESTIMATORS, name)


def detector(name: str) -> Appearance:
    return _appearance(DETECTORS, name)


#: Titles of estimators of other packages, for results on machines without these packages.
_ABSENT = {"minirocket": "MiniRocket"}


def _appearance(registry: Registry[Any], name: str) -> Appearance:
    entry = registry.get(name)
    if entry is None:
        return Appearance(_ABSENT.get(name, name.replace("_", " ").capitalize()), SKY)
    return Appearance(entry.title, entry.colour)


def estimators(scored: Iterable[str], baselines: bool = False) -> list[str]:
    """Return the estimators in ``scored`` in the order of reports.

    Baselines are left out, unless ``baselines`` is True.
    """
    names = set(scored)
    ours = [name for name in ESTIMATORS.builtin_names if name in names]
    return [
        name
        for name in (*ours, *sorted(names.difference(ours)))
        if baselines or not is_baseline(name)
    ]


def is_baseline(name: str) -> bool:
    """Return True if an estimator ignores the shape of the signal."""
    return name in ESTIMATORS and ESTIMATORS[name].baseline


def detectors(scored: Container[str]) -> list[str]:
    return [name for name in DETECTORS.names if name in scored]


def is_trained_detector(detector_name: str | None) -> bool:
    return detector_name in DETECTORS and DETECTORS[str(detector_name)].learns
