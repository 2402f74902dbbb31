"""An any-time model for one's own rig: its pinches are summed up, nothing is trained."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.anytime import InContextModel, Rig, Touches
from firstcontact.anytime.in_context import ANY
from firstcontact.core import Finger, InputError
from firstcontact.stiffness.folds import inner_folds

Values = NDArray[np.float64]

#: A finger with fewer pinches than this is not known by itself.
LEAST_OF_FINGER = 8
#: Of more pinches of a level, so many: the network was trained with hardly fewer, and on sessions
#: that were held out twenty-five times as many scored alike.
MOST_OF_LEVEL = 20
#: Folds in which the ways to know the rig are compared.
FOLDS = 3


@dataclass(frozen=True, slots=True, eq=False)
class Adapted:
    """A model that knows a rig.

    Parameters
    ----------
    model
        The model.
    way
        How the rig is known: what scored best on pinches that were held out.
    scores
        RMSE in Shore A of each way on those, 15 ms or what the second contact leaves of it.
    """

    model: InContextModel
    way: str
    scores: Mapping[str, float]


def adapt(
    base: InContextModel,
    touches: Touches,
    shore_a: Values,
    sessions: NDArray[np.str_] | None = None,
    seed: int = 0,
) -> Adapted:
    """Tell a pre-trained model of a rig.

    Both fingers may be alike, or two rigs of their own: what answers better for pinches that
    were held out is kept.

    Parameters
    ----------
    base
        Pre-trained.
    touches, shore_a
        Of things of known Shore A, shape (n,).
    sessions
        Held out whole where there are several, shape (n,).
    seed
        Of the folds.

    Raises
    ------
    InputError
        Fewer than two levels of Shore A, or fewer pinches than two of each.
    """
    lasting = touches.answerable
    longest, shore_a = touches.take(lasting), shore_a[lasting]
    sessions = None if sessions is None else sessions[lasting]
    if len(np.unique(shore_a)) < 2 or len(longest) < 4:
        raise InputError(
            f"a rig is known by pinches of two Shore A levels at least, and {len(longest)} of "
            f"{len(np.unique(shore_a))} are here: record more blocks"
        )
    scores = {
        way: score
        for way in WAYS
        if (score := _held_out(base, longest, shore_a, sessions, way, seed)) is not None
    }
    best = min(scores, key=lambda way: scores[way]) if scores else "one"
    return Adapted(base.told_of(_rigs(longest, shore_a, best, seed)), best, scores)


#: Ways to know a rig: all fingers as one, or each by itself.
WAYS = ("one", "each finger")


def _rigs(touches: Touches, shore_a: Values, way: str, seed: int) -> dict[int, Rig]:
    def rig(which: NDArray[np.intp]) -> Rig:
        some = which[_some(shore_a[which], seed)]
        return Rig.of(touches.take(some), shore_a[some])

    rigs = {ANY: rig(np.arange(len(touches)))}
    if way == WAYS[1]:
        for finger in range(len(Finger)):
            which = np.flatnonzero(touches.fingers == finger)
            if len(which) >= LEAST_OF_FINGER and len(np.unique(shore_a[which])) > 1:
                rigs[finger] = rig(which)
    return rigs


def _some(shore_a: Values, seed: int) -> NDArray[np.intp]:
    """Positions of no more than ``MOST_OF_LEVEL`` of each level, ascending."""
    rng = np.random.default_rng(seed)
    chosen = []
    for level in np.unique(shore_a):
        its = np.flatnonzero(shore_a == level)
        chosen.append(rng.permutation(its)[:MOST_OF_LEVEL])
    return np.sort(np.concatenate(chosen))


def _held_out(
    base: InContextModel,
    touches: Touches,
    shore_a: Values,
    sessions: NDArray[np.str_] | None,
    way: str,
    seed: int,
) -> float | None:
    """RMSE of answers for pinches that the rig is not known by; None where none can be."""
    errors: list[Values] = []
    for learn, ask in inner_folds(shore_a, sessions, seed, FOLDS):
        if len(np.unique(shore_a[learn])) < 2 or not len(ask):
            continue
        model = base.told_of(_rigs(touches.take(learn), shore_a[learn], way, seed))
        errors.append(model.answers(touches.take(ask)).values - shore_a[ask])
    if not errors:
        return None
    return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))
