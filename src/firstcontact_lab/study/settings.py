"""Settings of a study: size and seed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from firstcontact.contact import DETECTORS
from firstcontact.models import ESTIMATORS


@dataclass(frozen=True, slots=True)
class StudySettings:
    """Settings of a study: size and seed.

    Parameters
    ----------
    block_pinches, object_pinches
        Number of simulated pinches of each of the five flat blocks, and of each of the eight unseen
        objects.
    durations
        Window lengths to compare, s.
    folds
        Number of folds of a split by session.
    brief
        True for short trainings, which give worse models.
    calls
        Number of single-window predictions to time.
    detector
        Name of the contact detector that places the windows.
    early
        Longest time by which a contact may precede its label, s. For example, a label from a
        trigger circuit comes after the contact.
    rig_seeds
        Seeds of the simulated rigs for scores beyond the blocks.
    board
        Path of an ``embedded.json`` with the cost of models on the microcontroller. The report
        compares it with the time on this machine. If empty, this table is left out.
    delays
        Path of a ``live.json`` with measured delays of live estimates. If empty, the estimate in
        force is not scored.
    parts
        Names of the parts to run; parts that they need run, too. If empty, the default parts.
    seed
        Random seed of all draws except the rigs.
    workers
        Number of processes.
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
