"""Average of the network and a regression on the rig's own pinches, weighted by precision."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain.touch import predict_touches
from firstcontact.core.weights import take_array
from firstcontact.models.in_context import InContextModel
from firstcontact.models.model_file import pretrained
from firstcontact.models.network_estimator import (
    Adapted,
    NetworkEstimator,
    adapt_network,
    known_rigs,
    root_mean_square,
    score_held_out,
)
from firstcontact.models.rig import MOST_PINCHES, REGRESSED, Rig, RigRegression, level_groups
from firstcontact.models.touches import Touches
from firstcontact.models.window_model import Arrays, Values
from firstcontact.signal import samples_in

#: Smallest numbers of pinches and of Shore A levels for a regression. With fewer pinches or levels,
#: the network predicts alone.
LEAST_PINCHES, LEAST_LEVELS = 20, 3
#: Range of the factor by which the regression's spread is scaled.
_SCALES = 0.1, 10.0


class CombinedModel(InContextModel):
    """Network that is averaged with a regression on the pinches of the rig.

    Each prediction is a mixture of the network's prediction and the regression's, weighted by the
    inverse of their variances. The spread of a prediction is the standard deviation of the mixture,
    so it grows where network and regression differ. The regression dominates for contacts like
    those of the rig's pinches, the network for others.
    """

    kind: ClassVar[str] = "combined"

    def __init__(
        self,
        alone: InContextModel,
        factors: NDArray[np.float64],
        regressions: Mapping[int, RigRegression],
    ) -> None:
        super().__init__(
            alone.network, alone.familiar, factors, alone.level, alone.rigs, alone.mixed
        )
        self._alone = alone
        self._regressions = dict(regressions)

    @classmethod
    def fit(
        cls,
        base: InContextModel,
        touches: Touches,
        shore_a: Values,
        seed: int,
        scale: NDArray[np.float64],
    ) -> Self:
        """Return a model of a rig, from the network and a regression."""
        rigs = known_rigs(touches, shore_a, seed)
        regressions = {}
        for finger, (rig, members) in rigs.items():
            members = members[balanced_choice(shore_a[members], MOST_PINCHES, seed)]
            model = base.conditioned_on({Rig.ANY: rig})
            inputs = _stage_inputs(model, touches.take(members))
            regressions[finger] = RigRegression(inputs, shore_a[members], scale)
        networks = {finger: rig for finger, (rig, _) in rigs.items()}
        return cls(base.conditioned_on(networks), base.mixed, regressions)

    def network_alone(self) -> InContextModel:
        """Return the network without the regression, with its own interval widths."""
        return self._alone

    def with_network(self, alone: InContextModel) -> CombinedModel:
        """Return the model with ``alone`` as its network, conditioned on the same rigs."""
        return CombinedModel(alone, self.factors, self._regressions)

    def widened(self, scales: NDArray[np.float64]) -> CombinedModel:
        """Return the model with intervals widened by a factor for each stage, shape (stages,)."""
        return CombinedModel(self._alone, self.factors * scales, self._regressions)

    @property
    def regressions(self) -> Mapping[int, RigRegression]:
        """Regression of each rig, by finger number."""
        return self._regressions

    def regress(self, touches: Touches) -> tuple[Values, Values]:
        """Return the regression's predictions and their spreads, shape (n,) each."""
        out = predict_touches(self.image, *touches.arrays, is_regression=True)
        return out[:, 0], out[:, 4]

    def to_arrays(self) -> Arrays:
        """Return the network's arrays, and each regression's arrays as ``own.FINGER.NAME``."""
        arrays = super().to_arrays()
        arrays["own.factors"] = self._alone.factors
        for finger, regression in self._regressions.items():
            for name, array in regression.to_arrays().items():
                arrays[f"own.{finger}.{name}"] = array
        return arrays

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]], level: float) -> Self:
        """Build the model from the arrays that :meth:`to_arrays` returned."""
        own_factors = take_array(arrays, "own.factors", len(Rig.STAGES))
        alone = InContextModel.from_arrays({**arrays, "factors": own_factors}, level)
        regressions = {f: RigRegression.from_arrays(arrays, f"own.{f}.") for f in alone.rigs}
        factors = take_array(arrays, "factors", len(Rig.STAGES)).astype(np.float64)
        made = cls(alone, factors, regressions)
        made.image.handle  # noqa: B018 - refuse numbers that could overflow
        return made


@dataclass(frozen=True)
class CombinedEstimator(NetworkEstimator):
    """Estimator that averages the network with a regression on the rig's own pinches.

    With too few pinches or levels the network predicts alone.
    """

    name: ClassVar[str] = CombinedModel.kind
    title: ClassVar[str] = "Network and own pinches"
    model: ClassVar[Any] = CombinedModel

    def fit_touches(
        self,
        touches: Touches,
        shore_a: Values,
        sessions: NDArray[np.str_] | None = None,
        seed: int = 0,
    ) -> Adapted:
        """Condition the network on contacts, and fit the regression; see :func:`adapt_combined`."""
        return adapt_combined(pretrained(), touches, shore_a, sessions, seed)


def adapt_combined(
    base: InContextModel,
    touches: Touches,
    shore_a: Values,
    sessions: NDArray[np.str_] | None = None,
    seed: int = 0,
) -> Adapted:
    """Condition a network on a rig and average it with a regression on the rig's pinches."""
    adapted = adapt_network(base, touches, shore_a, sessions, seed)
    lasting = touches.answerable
    touches, shore_a = touches.take(lasting), shore_a[lasting]
    sessions = None if sessions is None else sessions[lasting]
    if len(touches) < LEAST_PINCHES or len(np.unique(shore_a)) < LEAST_LEVELS:
        few = f"fewer than {LEAST_PINCHES} pinches or {LEAST_LEVELS} levels"
        return replace(adapted, notes=(f"{few}: the network predicts alone",))
    scale = spread_scale(base, touches, shore_a, seed)

    def condition(touches: Touches, shore_a: Values) -> CombinedModel:
        return CombinedModel.fit(base, touches, shore_a, seed, scale)

    held_out = score_held_out(condition, touches, shore_a, sessions, seed)
    if held_out is None:
        return replace(adapted, notes=("no pinch can be held out: the network predicts alone",))
    check = held_out.check(base.level, touches.rate)
    model = condition(touches, shore_a).widened(check.scales).with_network(adapted.model)
    scores = {**adapted.scores, model.kind: root_mean_square(held_out.errors)}
    return Adapted(model, scores, root_mean_square(held_out.from_mean), check)


def spread_scale(
    base: InContextModel, touches: Touches, shore_a: Values, seed: int
) -> NDArray[np.float64]:
    """Return the factor of the regression's spread at each stage, shape (stages,)."""
    ones = np.ones(len(Rig.STAGES))
    squares = np.zeros((2, len(Touches.SCORED_MS)))
    groups = level_groups(shore_a)
    for group in np.unique(groups):
        is_asked = groups == group
        if len(np.unique(shore_a[~is_asked])) < 2:
            continue
        model = CombinedModel.fit(base, touches.take(~is_asked), shore_a[~is_asked], seed, ones)
        alone, truth = model.network_alone(), shore_a[is_asked]
        queries = touches.take(is_asked)
        for place, ms in enumerate(Touches.SCORED_MS):
            early = queries.until(samples_in(1e-3 * ms, touches.rate))
            network = alone.predict(early)
            for row, (values, spreads) in enumerate(
                ((network.value, network.spread), model.regress(early))
            ):
                squares[row, place] += np.sum(((values - truth) / spreads) ** 2)
    if not squares.all():
        return ones
    at = Rig.scored_stages(touches.rate)
    scale = np.clip(np.sqrt(squares[1] / squares[0]), *_SCALES)
    out: NDArray[np.float64] = np.exp(np.interp(Rig.STAGES, at, np.log(scale)))
    return out


def balanced_choice(shore_a: Values, most: int, seed: int) -> NDArray[np.intp]:
    """Return positions of at most ``most`` random pinches, as equally many of each Shore A."""
    order = np.random.default_rng(seed).permutation(len(shore_a))
    earlier = np.empty(len(order), np.intp)
    for level in np.unique(shore_a):
        is_member = shore_a[order] == level
        earlier[is_member] = np.arange(is_member.sum())
    chosen: NDArray[np.intp] = order[np.argsort(earlier, kind="stable")][:most]
    return chosen


def _stage_inputs(model: InContextModel, touches: Touches) -> NDArray[np.float64]:
    """Return the regression's inputs for n contacts, shape (stages, n, inputs)."""
    cuts = [model.inputs(touches.until(stage))[:, REGRESSED] for stage in Rig.STAGES]
    return np.stack(cuts).astype(np.float64)
