"""Settings of a grasp study: numbers of hands, objects and pinches, and random seed."""

from __future__ import annotations

from dataclasses import dataclass, replace

from firstcontact.grasp.household_policies import APPROACH, BOOST
from firstcontact.models import ESTIMATORS
from firstcontact.twin import TwinObject
from firstcontact.twin.household import HOUSEHOLD
from firstcontact.twin.objects import BRITTLE, EVERYDAY_OBJECTS, block

#: Largest Shore A of the objects that the payload task counts as soft.
SOFT = 20.0
#: Brake latency that the main table and the search for force feedback use, s.
HEADLINE = 0.020
#: Blocks that cannot break, from the softest to the firmest.
BLOCKS = tuple(block(s) for s in (5, 10, 15, 20, 30, 43, 60, 70))
KINDS = {kind.name: kind for kind in (*BLOCKS, *EVERYDAY_OBJECTS, *BRITTLE)}


@dataclass(frozen=True, slots=True)
class HouseholdSettings:
    """Settings of the household part."""

    tuning_hands: int = 3
    judged_hands: int = 4
    tuning_specimens: tuple[int, ...] = (1,)
    judged_specimens: tuple[int, ...] = (2, 3)
    blocks: int = 10
    speeds: tuple[float, ...] = APPROACH.tried
    boosts: tuple[float, ...] = BOOST.tried
    forces: tuple[float, ...] = (1.0, 1.41, 2.0, 2.83, 4.0, 5.66, 8.0, 12.0)
    folds: int = 6
    budget: int = 512
    few: bool = False
    permutations: int = 40
    kinds: tuple[str, ...] = tuple(item.name for item in HOUSEHOLD)

    def hand_seeds(self, seed: int) -> tuple[list[int], list[int]]:
        """Return the seeds of the hands for tuning, and of the hands for judging."""
        first = 1000 * (seed + 1)
        tuning = [first + 100 + n for n in range(self.tuning_hands)]
        return tuning, [first + 200 + n for n in range(self.judged_hands)]

    def quick(self) -> HouseholdSettings:
        """Return the settings of a quick trial. Do not quote its numbers."""
        return replace(
            self,
            tuning_hands=1,
            judged_hands=2,
            judged_specimens=(2,),
            blocks=6,
            speeds=APPROACH.few,
            boosts=BOOST.few,
            forces=(1.0, 2.0, 4.0, 8.0, 12.0),
            folds=3,
            budget=32,
            few=True,
            permutations=4,
            kinds=self.kinds[::4],
        )


@dataclass(frozen=True, slots=True)
class GraspStudySettings:
    """Size and seed of a grasp study."""

    household: HouseholdSettings = HouseholdSettings()
    sessions: int = 4
    latencies: tuple[float, ...] = (0.020,)
    training: int = 30
    windows: tuple[float, ...] = (0.005, 0.015)
    tuning: int = 1
    kinds: tuple[str, ...] = tuple(KINDS)
    model: str = ESTIMATORS.default
    detector: str | None = None
    seed: int = 0
    workers: int = 2

    def quick(self) -> GraspStudySettings:
        """Return settings of a quick trial that runs every part. Do not quote its numbers."""
        return replace(
            self,
            household=self.household.quick(),
            sessions=2,
            training=20,
            windows=(0.015,),
            kinds=("block 5", "block 20", "block 43", "orange 1", "egg shell"),
        )

    @property
    def objects(self) -> tuple[TwinObject, ...]:
        """Objects of the payload task."""
        return tuple(KINDS[name] for name in self.kinds)
