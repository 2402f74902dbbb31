"""Check that numbers in a compact network cannot become too large for C, for any contact.

In C, rounding an infinite number or NaN to an integer is undefined. So this module and the firmware
(``firmware/answers/fc_reach.c``) refuse networks that could produce one, instead of checking each
prediction.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import LARGEST, InputError
from firstcontact.models import FARTHEST, STAGES, CompactNetwork, InContextModel, Rounded

#: Largest allowed magnitude of any number in the network.
MOST = LARGEST


def check_reach(model: InContextModel, network: CompactNetwork) -> None:
    """Refuse a model whose compact network could overflow.

    Raises
    ------
    InputError
        A value of the network could be too large for C, or a rig's signal level is not usable.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        bounded = _bounded(model, network)
    if not bounded:
        raise InputError(
            "the network's weights are so large that its predictions may overflow on the hand: "
            "make the model again with `firstcontact adapt`"
        )


def _bounded(model: InContextModel, network: CompactNetwork) -> bool:
    mean, sd = network.scale("inputs")
    good = _largest(mean) < MOST and 1 / MOST < float(sd.min()) <= float(sd.max()) < MOST
    good = good and _largest(model.familiar.mean) < MOST
    good = good and bool(np.isfinite(model.familiar.whitening.astype(np.float32)).all())
    hidden = _pair(network, "query1", FARTHEST)
    query = _pair(network, "query2", hidden)
    for finger, rig in model.rigs.items():
        context = model.context(finger)
        largest = max(hidden, _largest(context.values))
        along = np.abs([network.along(context, s) for s in range(len(STAGES))]).max(axis=0)
        body = _pair(network, "body1", largest, along)
        body = _pair(network, "body3", _pair(network, "body2", body))
        weight, bias = (np.abs(x.astype(np.float64)) for x in network.answer)
        fit = query * _largest(context.keys) * len(network.thin["query2"].out.bias)
        raw = float((weight.sum(axis=1) * body + bias).max())
        good = good and 1e-9 < rig.level < 1e9 and fit < MOST and raw < MOST
    return good and query < MOST


def _pair(
    network: CompactNetwork, name: str, most: float, bias: NDArray[np.floating] | None = None
) -> float:
    """Return the largest output of a pair of thin layers; infinite if a sum in them can overflow.

    ``most`` is the largest input.
    """
    thin = network.thin[name]
    along = _layer(thin.into, most, thin.into.bias if bias is None else bias)
    out = _layer(thin.out, along, thin.out.bias)
    return out if max(along, out) < MOST else np.inf


def _layer(layer: Rounded, most: float, bias: NDArray[np.floating]) -> float:
    sums = np.abs(layer.integers.astype(np.float64)).sum(axis=1)
    each = sums * np.abs(layer.scale.astype(np.float64)) * min(most, MOST)
    largest = float((each + np.abs(bias.astype(np.float64))).max())
    return largest if largest == largest and most < MOST else np.inf


def _largest(x: NDArray[np.floating]) -> float:
    """Return the largest magnitude in an array; infinite if a value is NaN."""
    largest = float(np.abs(x.astype(np.float64)).max(initial=0.0))
    return largest if largest == largest else np.inf
