"""Average of the network and a regression on the rig's own pinches, weighted by precision."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.models.rig.network_estimator import (
    Adapted,
    NetworkEstimator,
    adapt_network,
    known_rigs,
    root_mean_square,
    score_held_out,
)
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.rig.rigs import MOST_PINCHES, REGRESSED, Rig, RigRegression, level_groups
from firstcontact.models.touches import Touches
from firstcontact.models.values import Values
from firstcontact.signal import samples_in

#: Smallest numbers of pinches and of Shore A levels for a regression. With fewer pinches or levels,
#: the network predicts alone.
LEAST_PINCHES, LEAST_LEVELS = 20, 3
#: Range of the factor by which the regression's spread is scaled.
_SCALES = 0.1, 10.0


def average_with_regressions(
    base: RigModel, touches: Touches, shore_a: Values, seed: int, scale: NDArray[np.float64]
) -> RigModel:
    """Return the network adapted to a rig, averaged with a regression on the rig's pinches.

    ``base`` is the network. ``scale`` multiplies the regression's standard deviations, shape
    (signal lengths,).
    """
    rigs = known_rigs(touches, shore_a, seed)
    regressions = {}
    for finger, (rig, members) in rigs.items():
        members = members[balanced_choice(shore_a[members], MOST_PINCHES, seed)]
        inputs = _stage_inputs(base.conditioned_on({Rig.ANY: rig}), touches.take(members))
        regressions[finger] = RigRegression(
            inputs, shore_a[members], scale, np.zeros(len(Rig.STAGES))
        )
    network = base.conditioned_on({finger: rig for finger, (rig, _) in rigs.items()})
    return network.with_regressions(regressions, base.mixed)


def adapt_combined(
    base: RigModel,
    touches: Touches,
    shore_a: Values,
    sessions: NDArray[np.str_] | None = None,
    seed: int = 0,
) -> Adapted:
    """Adapt the network to a rig, and average it with a regression on the rig's pinches."""
    adapted = adapt_network(base, touches, shore_a, sessions, seed)
    lasting = touches.answerable
    touches, shore_a = touches.take(lasting).as_blocks(), shore_a[lasting]
    sessions = None if sessions is None else sessions[lasting]
    if len(touches) < LEAST_PINCHES or len(np.unique(shore_a)) < LEAST_LEVELS:
        few = f"fewer than {LEAST_PINCHES} pinches or {LEAST_LEVELS} values of Shore A"
        return replace(adapted, notes=(f"the network predicts alone, because there are {few}",))
    scale = spread_scale(base, touches, shore_a, seed)

    def condition(touches: Touches, shore_a: Values) -> RigModel:
        return average_with_regressions(base, touches, shore_a, seed, scale)

    held_out = score_held_out(condition, touches, shore_a, sessions, seed)
    if held_out is None:
        return replace(
            adapted, notes=("the network predicts alone, because no pinch can be held out",)
        )
    offset = held_out.offset(shore_a, touches.rate)
    held_out = held_out.less_offset(shore_a)
    check = held_out.check(base.level, touches.rate, is_average=True)
    average = condition(touches, shore_a).rescaled(check.scales)
    shifted = {finger: r.shifted(offset) for finger, r in average.regressions.items()}
    model = adapted.model.with_regressions(shifted, average.factors)
    scores = {**adapted.scores, model.name: root_mean_square(held_out.errors[-1])}
    note = (
        f"{-offset.max():+.1f} to {-offset.min():+.1f} Shore A are added to all predictions, "
        "depending on the time, to remove the bias on held-out blocks; the errors and intervals of "
        "a block are checked with the correction that the other blocks give"
    )
    notes = (note,) if offset.any() else ()
    return Adapted(model, scores, root_mean_square(held_out.from_mean), check, notes)


@dataclass(frozen=True)
class CombinedEstimator(NetworkEstimator):
    """Estimator that averages the network with a regression on the rig's own pinches.

    With too few pinches, or too few values of Shore A, the network predicts alone.
    """

    name: ClassVar[str] = RigModel.COMBINED
    title: ClassVar[str] = "Network and own pinches"
    adapt: ClassVar[Callable[..., Adapted]] = staticmethod(adapt_combined)


def spread_scale(
    base: RigModel, touches: Touches, shore_a: Values, seed: int
) -> NDArray[np.float64]:
    """Return the factors that make a regression as well calibrated as the network.

    Each factor multiplies the regression's standard deviations at one signal length, shape (signal
    lengths,). Pinches of each Shore A are held out in turn to choose the factors.
    """
    ones = np.ones(len(Rig.STAGES))
    squares = np.zeros((2, len(Touches.SCORED_MS)))
    groups = level_groups(shore_a)
    for group in np.unique(groups):
        is_asked = groups == group
        if len(np.unique(shore_a[~is_asked])) < 2:
            continue
        model = average_with_regressions(
            base, touches.take(~is_asked), shore_a[~is_asked], seed, ones
        )
        alone, truth = model.network_alone(), shore_a[is_asked]
        queries = touches.take(is_asked)
        for place, ms in enumerate(Touches.SCORED_MS):
            early = queries.until(samples_in(1e-3 * ms, touches.rate))
            network = alone.predict_touches(early)
            for row, (values, spreads) in enumerate(
                ((network.value, network.spread), model.regress(early))
            ):
                squares[row, place] += np.sum(((values - truth) / spreads) ** 2)
    if not squares.all():
        return ones
    at = Rig.stages_at_scored_times(touches.rate)
    scale = np.clip(np.sqrt(squares[1] / squares[0]), *_SCALES)
    out: NDArray[np.float64] = np.exp(np.interp(Rig.STAGES, at, np.log(scale)))
    return out


def balanced_choice(shore_a: Values, most: int, seed: int) -> NDArray[np.intp]:
    """Return positions of at most ``most`` random pinches, about as many of each Shore A."""
    order = np.random.default_rng(seed).permutation(len(shore_a))
    earlier = np.empty(len(order), np.intp)
    for level in np.unique(shore_a):
        is_member = shore_a[order] == level
        earlier[is_member] = np.arange(is_member.sum())
    chosen: NDArray[np.intp] = order[np.argsort(earlier, kind="stable")][:most]
    return chosen


def _stage_inputs(model: RigModel, touches: Touches) -> NDArray[np.float64]:
    """Return the inputs of the rig's regression, shape (signal lengths, contacts, inputs).

    The signal lengths are :attr:`Rig.STAGES`.
    """
    cuts = [model.inputs(touches.until(stage))[:, REGRESSED] for stage in Rig.STAGES]
    return np.stack(cuts).astype(np.float64)
