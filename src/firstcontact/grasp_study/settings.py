"""How large a grasp study is, and what is compared in it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from firstcontact.stiffness.registry import ESTIMATORS
from firstcontact.twin.objects import BRITTLE, EVERYDAY_OBJECTS, TwinObject, block

#: Objects up to this Shore A are the soft ones of the headline.
SOFT = 20.0
#: The brake latency of the headline and of the search for force feedback, s.
HEADLINE = 0.020
#: Blocks that cannot break, from the softest to the firmest.
BLOCKS = tuple(block(s) for s in (5, 10, 15, 20, 30, 43, 60, 70))
KINDS = {kind.name: kind for kind in (*BLOCKS, *EVERYDAY_OBJECTS, *BRITTLE)}


@dataclass(frozen=True, slots=True)
class GraspStudySettings:
    """Size and seed of a grasp study.

    Parameters
    ----------
    sessions
        Each has one pinch of every object, each pinch with a specimen of its own.
    latencies
        Of the brake, s; the headline's is among them.
    training
        Pinches of each of the five blocks that detector and models learn from.
    windows
        Of the models, s.
    tuning
        Pinches of each object that force feedback is chosen on.
    coarse
        Whether the search for force feedback is a small one.
    kinds
        Names of the objects.
    model, detector
        Names of the estimator and of the contact detector; None for the usual one.
    seed
        Of everything drawn.
    workers
        Processes.
    """

    sessions: int = 12
    latencies: tuple[float, ...] = (0.0, 0.020, 0.040, 0.060, 0.080)
    training: int = 60
    windows: tuple[float, ...] = (0.003, 0.005, 0.008, 0.015)
    tuning: int = 3
    coarse: bool = False
    kinds: tuple[str, ...] = tuple(KINDS)
    model: str = ESTIMATORS.default
    detector: str | None = None
    seed: int = 0
    workers: int = 2

    def quick(self) -> GraspStudySettings:
        """The same study, small: every part runs, no number is to be quoted."""
        return replace(
            self,
            sessions=3,
            latencies=(0.020, 0.060),
            training=20,
            windows=(0.003, 0.015),
            tuning=1,
            coarse=True,
            kinds=("block 5", "block 20", "block 43", "block 70", "orange 1", "egg shell", "berry"),
        )

    @property
    def objects(self) -> tuple[TwinObject, ...]:
        """What is pinched."""
        return tuple(KINDS[name] for name in self.kinds)
