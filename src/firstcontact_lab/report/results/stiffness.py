"""How well estimators do, in every split and on unseen objects."""

from __future__ import annotations

from collections.abc import Mapping

from firstcontact.core import ByName, Record
from firstcontact.models import Ends, InferenceTime, MeanErrors, RegressionScores, SpecimenErrors


class WindowCounts(Record, frozen=True, kw_only=True):
    """Pinches with a label, and how many of them have a window."""

    pinches: int
    with_window: int


class SplitScores(Record, frozen=True, kw_only=True):
    """Regression and classification in one split, as far as they were asked for.

    ``per_level`` has the errors of each Shore A level by itself.
    """

    rmse: float | None = None
    mae: float | None = None
    mse: float | None = None
    bias: float | None = None
    n: int
    spearman: float | None = None
    accuracy: float | None = None
    classes: list[float] | None = None
    confusion: list[list[int]] | None = None
    intervals: dict[str, Ends]
    per_level: dict[str, RegressionScores] | None = None


class BlockScores(Record, frozen=True, kw_only=True):
    """An estimator in the splits of the blocks.

    ``strip_aligned`` has the same with windows that start at the known contact.
    """

    random_90_10: SplitScores | None = None
    by_session: SplitScores | None = None
    leave_one_shore_out: SplitScores | None = None
    strip_aligned: BlockScores | None = None

    def split(self, name: str) -> SplitScores | None:
        """The scores of a split."""
        found: SplitScores | None = getattr(self, name)
        return found


class BlockConditions(Record, frozen=True, kw_only=True):
    """What holds for all estimators on blocks."""

    windows: WindowCounts | None = None


class ObjectScores(RegressionScores, frozen=True, kw_only=True):
    """An estimator on unseen objects: per pinch, per specimen, and of their means."""

    per_object: dict[str, SpecimenErrors]
    over_objects: MeanErrors
    strip_aligned: ObjectScores | None = None


class ObjectConditions(Record, frozen=True, kw_only=True):
    """What holds for all estimators on objects; ``shares``: what both roles may have in common."""

    windows: WindowCounts | None = None
    shares: list[str] | None = None


class WindowErrors(Record, frozen=True, kw_only=True):
    """Errors with one length of window."""

    blocks: RegressionScores | None = None
    objects: RegressionScores | None = None


class WindowSearch(Record, frozen=True, kw_only=True):
    """On how many windows hyper-parameters were searched."""

    windows: int


class SecondContact(Record, frozen=True, kw_only=True):
    """Errors by where the second contact lies: "with", "without" or "misplaced"."""

    blocks: dict[str, RegressionScores] | None = None
    objects: dict[str, RegressionScores] | None = None


def by_side(
    found: Mapping[str, SecondContact],
) -> list[tuple[str, str, str, RegressionScores]]:
    """Estimator, side, where and errors: first all of the blocks, then all of the objects."""
    sides = [("blocks", model, its.blocks) for model, its in found.items()]
    sides += [("objects", model, its.objects) for model, its in found.items()]
    return [
        (model, side, where, scores)
        for side, model, its in sides
        for where, scores in (its or {}).items()
    ]


class InferenceTimes(InferenceTime, frozen=True, kw_only=True):
    """Of an estimator's regression, or of all that it can; ``classification`` beside it."""

    classification: InferenceTime | None = None


#: Scores by the name of the estimator.
BlockResults = ByName[BlockScores, BlockConditions]
ObjectResults = ByName[ObjectScores, ObjectConditions]
