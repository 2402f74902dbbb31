"""Settings of a grasp study: numbers of hands, objects and pinches, and random seed."""

from __future__ import annotations

from dataclasses import dataclass, replace

from firstcontact.grasp.household_policies import APPROACH, BOOST
from firstcontact.twin.household import HOUSEHOLD


@dataclass(frozen=True, slots=True)
class GraspStudySettings:
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
    seed: int = 0
    workers: int = 2

    def hand_seeds(self) -> tuple[list[int], list[int]]:
        """Return the seeds of the hands for tuning, and of the hands for judging."""
        first = 1000 * (self.seed + 1)
        tuning = [first + 100 + n for n in range(self.tuning_hands)]
        return tuning, [first + 200 + n for n in range(self.judged_hands)]

    def quick(self) -> GraspStudySettings:
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
