"""Predictions by the compiled kernels, which need a tenth of NumPy's time for one contact."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import kernels
from firstcontact.models._context_network import Network
from firstcontact.models._out_of_range import GAIN

if TYPE_CHECKING:
    from firstcontact.models._in_context import InContextModel

#: Function of a signal, its samples, the stage, the inputs besides the signal, and the noise before
#: the contact. It returns value, low, high, half width and the out-of-range flag; None if they are
#: not finite.
Predict = Callable[
    [NDArray[np.float32], int, int, NDArray[np.float64], float],
    tuple[float, float, float, float, bool] | None,
]

_cache: WeakKeyDictionary[InContextModel, dict[int, Predict | None]] = WeakKeyDictionary()


def compiled_prediction(model: InContextModel, finger: int) -> Predict | None:
    """Return a compiled function that predicts for a rig of a model; None if no kernel fits.

    No kernel fits a compact network, or a model that refines the network's predictions other than
    by a regression.

    Predictions differ from NumPy's by rounding only.

    Parameters
    ----------
    model
        Network, conditioned on rigs.
    finger
        Finger number of the rig.
    """
    if kernels() is None:
        return None
    rigs = _cache.get(model)
    if rigs is None:
        rigs = _cache[model] = _compile(model)
    return rigs[finger]


def _compile(model: InContextModel) -> dict[int, Predict | None]:
    module = kernels()
    network = model.network
    # Other arithmetic has no kernel: reduced networks, and further kinds of models.
    if module is None or type(network) is not Network or not _refines_alone(model):
        return dict.fromkeys(model.rigs)
    layers = network.layers
    hidden, width = len(layers["query1"][1]), len(layers["mean"][1])
    weight, bias = layers["body1"]
    attended = len(layers["value"][1])
    parts = (hidden, hidden + width, hidden + width + attended)
    of_hidden, of_mean, of_attended, of_general = np.split(weight, parts, axis=1)
    names = ("query1", "query2", "body1", "body2", "body3", "answer")
    moving = {**layers, "body1": (np.concatenate([of_hidden, of_attended], axis=1), bias)}
    familiar, stages = model.familiar, len(model.factors)
    outputs = [len(layers[name][1]) for name in names]
    arrays = [
        *network.scale("inputs"),
        *map(_double, (familiar.mean, familiar.whitening, familiar.limit, GAIN, model.factors)),
    ]
    for name in names:
        arrays += [_single(moving[name][0].T), _single(moving[name][1])]
    sizes = (stages, outputs[0], outputs[1], attended, *outputs[2:5])
    try:
        shared = module.network(sizes, tuple(arrays))
        rigs: dict[int, Predict | None] = {}
        for finger, rig in model.rigs.items():
            regression = model.regression(finger)
            if model.refines and regression is None:
                return dict.fromkeys(model.rigs)
            context = model.context(finger)
            along = context.mean @ of_mean.T + context.general @ of_general.T + bias
            fitted = (np.zeros(0),) * 7 if regression is None else regression.stacked()
            centre, unit, n = (0.0, 1.0, 0) if regression is None else regression.constants
            constants = module.rig(
                shared,
                (context.keys.shape[2], n),
                (rig.level, rig.sign, centre, unit),
                (*map(_single, (along, context.keys, context.values)), *map(_double, fitted)),
            )
            rigs[finger] = partial(module.predict, shared, constants)
    except ValueError:  # larger than the kernels' room
        return dict.fromkeys(model.rigs)
    return rigs


def _refines_alone(model: InContextModel) -> bool:
    """Return True if one class of this package defines both ``refine`` and ``regression``."""
    refine, regression = (
        next(kind for kind in type(model).__mro__ if name in vars(kind))
        for name in ("refine", "regression")
    )
    return refine is regression and refine.__module__.startswith("firstcontact.models.")


def _single(array: NDArray[np.generic]) -> NDArray[np.float32]:
    return np.ascontiguousarray(array, np.float32)


def _double(array: NDArray[np.generic]) -> NDArray[np.float64]:
    return np.ascontiguousarray(array, np.float64)
