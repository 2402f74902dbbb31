"""Settings of a study: size and seed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from firstcontact.contact import DETECTORS
from firstcontact.models import ESTIMATORS


@dataclass(frozen=True, slots=True)
class StudySettings:
    """Settings of a study: size and seed."""

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
    delays: str = ""
    parts: tuple[str, ...] = ()
    seed: int = 0
    workers: int = 2

    def quick(self) -> StudySettings:
        """Return settings of a quick trial that runs every part. Do not quote its numbers."""
        return replace(
            self,
            block_pinches=20,
            object_pinches=5,
            durations=(0.003, 0.008, 0.015),
            folds=3,
            brief=True,
            calls=500,
            rig_seeds=(601,),
        )

    def options(self, estimator: str) -> Mapping[str, Any]:
        """Return the options of an estimator for this study."""
        return ESTIMATORS[estimator].quick if self.brief else {}
