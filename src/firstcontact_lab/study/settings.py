"""Size and seed of a study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from firstcontact.contact import DETECTORS
from firstcontact.models import ESTIMATORS


@dataclass(frozen=True, slots=True)
class StudySettings:
    """Size and seed of a study.

    Parameters
    ----------
    block_pinches, object_pinches
        Twin pinches for each of the 5 blocks and of the 8 objects.
    durations
        Window lengths to compare, s.
    folds
        Folds of a split by session.
    brief
        Whether estimators learn quickly rather than well.
    calls
        Single-window predictions that are timed.
    detector
        Name of the contact detector that says where windows start.
    early
        How much earlier than its label a contact may be, s: labels that come
        from a trigger are late.
    rig_seeds
        Of the twin's rigs that estimators are asked about off their blocks.
    board
        ``embedded.json`` with what models cost on the microcontroller, shown beside what
        they take here; "" for no such table.
    parts
        Names of the parts to run, besides those that they need; the default parts if empty.
    seed
        Of everything drawn but those.
    workers
        Processes.
    """

    block_pinches: int = 500
    object_pinches: int = 50
    durations: tuple[float, ...] = (0.002, 0.003, 0.005, 0.008, 0.010, 0.015)
    folds: int = 5
    brief: bool = False
    calls: int = 2_000
    detector: str = DETECTORS.default
    early: float = 0.0
    rig_seeds: tuple[int, ...] = (601, 602, 603, 604, 605, 606)
    board: str = ""
    parts: tuple[str, ...] = ()
    seed: int = 0
    workers: int = 2

    def quick(self) -> StudySettings:
        """Return settings of a quick trial that runs every part. Do not quote its numbers."""
        return replace(
            self,
            block_pinches=40,
            object_pinches=10,
            durations=(0.003, 0.008, 0.015),
            folds=3,
            brief=True,
            calls=500,
            rig_seeds=(601,),
        )

    def options(self, estimator: str) -> Mapping[str, Any]:
        """Fields with which an estimator learns here."""
        return ESTIMATORS[estimator].quick if self.brief else {}
