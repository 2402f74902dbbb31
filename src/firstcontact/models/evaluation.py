"""Scores of a predictor on groups of pinches, by their relation to the training of the model."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING

from firstcontact.core.display import Drawable
from firstcontact.core.installation import require_modules
from firstcontact.core.quantity import QUANTITIES, Quantity
from firstcontact.core.text import counted
from firstcontact.models.card import Target
from firstcontact.models.scores import RegressionScores, SpecimenErrors, TaskScores

if TYPE_CHECKING:
    from pandas import DataFrame


class Overlap(StrEnum):
    """Relation of a group of pinches to the training data of a model. The value is its title."""

    NONE = "not seen in training"
    SESSION = "sessions of the training by name, other specimens"
    SPECIMEN = "specimens of the training, other sessions"
    NAMESAKES = "names as in the training, other samples"
    SEEN = "seen in training"


@dataclass(frozen=True, slots=True, kw_only=True)
class GroupScores:
    """Scores of one predictor on a group of pinches, such as those not seen in training.

    In ``scores``, ``coverage``, ``width`` and ``out_of_range``, each key is the time of the scored
    predictions after the contact, s. ``out_of_range`` is empty for window models. For models
    without prediction intervals, ``coverage`` and ``width`` are empty and ``level`` is None.

    Parameters
    ----------
    title, predictor
        Title of the group, and name of the estimator.
    n
        Number of pinches.
    scores
        Errors in the unit of the target, or the accuracy of classes, with bootstrap intervals.
        Errors and widths of a modulus or a stiffness are those of its natural logarithm.
    coverage, width
        Share of true values inside the prediction intervals (0 to 1), and mean width of these.
    out_of_range
        Share of contacts that the model marks as unlike its training data, 0 to 1.
    objects
        Errors for each specimen (one physical object) at the latest time.
    constant
        RMSE of always predicting the mean label of the group; None for classes.
    level
        Nominal coverage of the prediction intervals, such as 0.9.
    """

    title: Overlap
    predictor: str
    n: int
    scores: Mapping[float, TaskScores]
    coverage: Mapping[float, float] = field(default_factory=dict)
    width: Mapping[float, float] = field(default_factory=dict)
    out_of_range: Mapping[float, float] = field(default_factory=dict)
    objects: Mapping[str, SpecimenErrors] = field(default_factory=dict)
    constant: float | None = None
    level: float | None = None

    @property
    def rmse(self) -> Mapping[float, float]:
        """Root mean square errors. Each key is a time after the contact, s. Empty for classes."""
        return {at: s.rmse for at, s in self.scores.items() if isinstance(s, RegressionScores)}

    @property
    def bias(self) -> Mapping[float, float]:
        """Mean errors. Each key is a time after the contact, s. Empty for classes."""
        return {at: s.bias for at, s in self.scores.items() if isinstance(s, RegressionScores)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Evaluation(Drawable):
    """Scores of one predictor of a model.

    :attr:`rmse`, :attr:`bias`, :attr:`coverage` and :attr:`width` leave out the pinches that the
    model was trained on. If other pinches remain, they also leave out those whose session and
    specimen both have names that occur in the training data.

    Parameters
    ----------
    predictor
        Name of the estimator, such as "svm" or "network".
    target
        Label that the predictor predicts.
    contacts
        Source of the contacts at which predictions start: "known ..." or "detected ...".
    scored, left_out
        Number of scored pinches, and number of all others. The others lack a contact, a label, or
        enough signal before the second finger's contact, or belong to a class unknown to the model.
    warnings
        Sentences about scores that are too good or too bad, such as those of training pinches.
    groups
        Scores of each group of pinches. Pinches that were not seen in training come first.
    duration
        Length of the signal after the contact that a window model uses, s; None for an any-time
        model, such as the network.
    """

    predictor: str
    target: Target
    contacts: str
    scored: int
    left_out: int
    warnings: tuple[str, ...]
    groups: tuple[GroupScores, ...]
    duration: float | None = None

    @property
    def quantity(self) -> Quantity:
        """Quantity of the target, with its unit."""
        return QUANTITIES[self.target]

    @property
    def when(self) -> str:
        """Time from contact to prediction as text: "15 ms", or "at any time" (any-time model)."""
        return "at any time" if self.duration is None else f"{1e3 * self.duration:g} ms"

    @property
    def rmse(self) -> Mapping[float, float]:
        """Root mean square errors in the target's unit. Each key is a time after the contact, s.

        The mapping is empty for classes, and if the model was trained on all pinches.
        """
        squares = self._unseen_mean(lambda group: {at: r * r for at, r in group.rmse.items()})
        return {at: math.sqrt(square) for at, square in squares.items()}

    @property
    def bias(self) -> Mapping[float, float]:
        """Mean errors in the target's unit.

        Each key is a time after the contact, s; see :attr:`rmse`.
        """
        return self._unseen_mean(lambda group: group.bias)

    @property
    def coverage(self) -> Mapping[float, float]:
        """Share of intervals that contain the true value. Each key is a time after contact, s."""
        return self._unseen_mean(lambda group: group.coverage)

    @property
    def width(self) -> Mapping[float, float]:
        """Mean widths of intervals in the target's unit. Each key is a time after contact, s."""
        return self._unseen_mean(lambda group: group.width)

    def __repr__(self) -> str:
        """Return the name of the predictor, and its error at the latest time."""
        at = max(self.rmse, default=0.0)
        error = f", {self.rmse[at]:.3g} RMSE at {1e3 * at:g} ms" if at else ""
        return f"Evaluation({self.predictor}, {counted(self.scored, 'pinch')}{error})"

    def to_frame(self) -> DataFrame:
        """Return a pandas table of scores, one row for each group of pinches and elapsed time.

        Errors and widths have the unit of the target, usually Shore A. Those of a modulus or a
        stiffness are of its natural logarithm.
        """
        require_modules("notebook", "pandas")
        from pandas import DataFrame

        return DataFrame(
            {
                "group": str(group.title),
                "pinches": group.n,
                "elapsed_ms": 1e3 * at,
                **{
                    name: getattr(scores, name, math.nan)
                    for name in ("rmse", "bias", "mae", "accuracy")
                },
                "coverage_percent": 100 * group.coverage.get(at, math.nan),
                "width": group.width.get(at, math.nan),
            }
            for group in self.groups
            for at, scores in group.scores.items()
        )

    def _unseen_mean(
        self, values: Callable[[GroupScores], Mapping[float, float]]
    ) -> dict[float, float]:
        """Return the mean of one score over the pinches that were not seen in training, by time.

        ``values`` selects the score of a group of pinches. Times are after the contact, s.
        """
        unseen = [group for group in self.groups if group.title is not Overlap.SEEN]
        groups = [group for group in unseen if group.title is not Overlap.NAMESAKES] or unseen
        n = sum(group.n for group in groups)
        out: dict[float, float] = {}
        for group in groups:
            for at, value in values(group).items():
                out[at] = out.get(at, 0.0) + group.n / n * value
        return out
