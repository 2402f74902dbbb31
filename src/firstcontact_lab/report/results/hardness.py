"""Order of hardness where no Shore A is known."""

from __future__ import annotations

from firstcontact.core import Record
from firstcontact.models import ClassificationScores, RankCorrelation, RegressionScores


class Material(Record, frozen=True, kw_only=True):
    """Means of one material's pinches."""

    rank: float
    n: int
    centroid_hz: float
    predicted: float | None = None


class RankRegression(RankCorrelation, frozen=True, kw_only=True):
    """Over materials, and errors over pinches in ranks."""

    errors: RegressionScores


class MaterialLeftOut(Record, frozen=True, kw_only=True):
    """Each material answered by models that did not learn from it."""

    rank_regression: RankRegression | None = None
    classification: dict[str, ClassificationScores] | None = None


class HardnessOrder(Record, frozen=True, kw_only=True):
    """Rank correlations over materials, and classes, as far as these pinches permit.

    ``n_pinches`` of ``pinches`` with a rank have a window; ``score`` says what orders materials
    without training.
    """

    n_pinches: int
    pinches: int
    score: str
    spectral_centroid: RankCorrelation
    by_material: dict[str, Material]
    leave_one_material_out: MaterialLeftOut | None = None
    random_folds: dict[str, ClassificationScores] | None = None

    @property
    def rho_left_out(self) -> float | None:
        """Of the regression of the rank, each material predicted without having been learned."""
        left_out = self.leave_one_material_out
        regression = left_out.rank_regression if left_out else None
        return regression.rho if regression else None

    def classes_left_out(self) -> dict[str, ClassificationScores]:
        """By the name of the estimator; empty where these pinches do not permit it."""
        left_out = self.leave_one_material_out
        return (left_out.classification if left_out else None) or {}
