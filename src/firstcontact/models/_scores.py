"""Records of scores, as results hold them."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from firstcontact.core import Record

#: Low and high end of an interval.
Ends = tuple[float, float]


class RegressionScores(Record, frozen=True, kw_only=True):
    """Errors over ``n`` pinches in the unit of the target; bias is predicted minus true.

    ``spearman`` where both sides vary; ``intervals`` by score, empty with fewer than two clusters.
    """

    rmse: float
    mae: float
    mse: float
    bias: float
    n: int
    spearman: float | None = None
    intervals: dict[str, Ends]


class ClassificationScores(Record, frozen=True, kw_only=True):
    """Accuracy over ``n`` pinches, and counts of which class (row) was taken for which (column)."""

    accuracy: float
    n: int
    classes: list[float]
    confusion: list[list[int]]
    intervals: dict[str, Ends]

    @property
    def best_constant(self) -> float:
        """Accuracy of the constant prediction that scores best on these pinches."""
        return max(map(sum, self.confusion), default=0) / self.n


#: Of whatever was asked of a model.
TaskScores = RegressionScores | ClassificationScores


class SpecimenErrors(Record, frozen=True, kw_only=True):
    """Errors of one specimen: of its pinches, and of their mean; ``sd`` of two pinches or more."""

    object: str
    n: int
    true: float
    mean: float
    sd: float | None = None
    bias: float
    rmse: float
    mae: float
    mse: float


class Scores(Protocol):
    """Any record of scores that has intervals."""

    @property
    def intervals(self) -> dict[str, Ends]:
        """Return the scores by name."""
        ...


class Bounded(NamedTuple):
    """A score with its interval, where it has one."""

    value: float
    ends: Ends | None = None


def bounded(scores: Scores | None, name: str) -> Bounded | None:
    """Return a score of a record with its interval, or None."""
    value = getattr(scores, name, None)
    return None if scores is None or value is None else Bounded(value, scores.intervals.get(name))
