"""Records of scores in results files."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from firstcontact.core import Record

#: Lower and upper end of an interval.
Ends = tuple[float, float]


class RegressionScores(Record, frozen=True, kw_only=True):
    """Errors over ``n`` pinches, in the unit of the target.

    ``bias`` is the mean prediction minus the mean truth. ``spearman`` is present if both truths and
    predictions vary. ``intervals`` holds the interval of each score by its name. It comes from a
    bootstrap that draws whole sessions or specimens, and is empty if there are fewer than five.
    """

    rmse: float
    mae: float
    mse: float
    bias: float
    n: int
    spearman: float | None = None
    intervals: dict[str, Ends]


class ClassificationScores(Record, frozen=True, kw_only=True):
    """Accuracy over ``n`` pinches, and confusion matrix (rows true, columns predicted)."""

    accuracy: float
    n: int
    classes: list[float]
    confusion: list[list[int]]
    intervals: dict[str, Ends]

    @property
    def best_constant(self) -> float:
        """Accuracy of the constant prediction that scores best on these pinches."""
        return max(map(sum, self.confusion), default=0) / self.n


#: Scores of a regression or a classification.
TaskScores = RegressionScores | ClassificationScores


class SpecimenErrors(Record, frozen=True, kw_only=True):
    """Mean prediction for one specimen, and errors of its single pinches.

    ``true`` is the label and ``mean`` the mean prediction. ``sd`` is the standard deviation of the
    predictions; None for a single pinch.
    """

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
    """Interface of score records that have intervals."""

    @property
    def intervals(self) -> dict[str, Ends]:
        """Interval of each score, by its name."""
        ...


class Bounded(NamedTuple):
    """Score with its interval, if it has one."""

    value: float
    ends: Ends | None = None


def bounded(scores: Scores | None, name: str) -> Bounded | None:
    """Return a score of a record with its interval; None if the record lacks the score."""
    value = getattr(scores, name, None)
    return None if scores is None or value is None else Bounded(value, scores.intervals.get(name))
