"""The steps that models are described by; each has a kernel in C of the same name.

All make one vector, named ``gives``, from the vectors named in ``takes``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.program import Constants, Step

Real = NDArray[Any]


def flat32(array: Real) -> NDArray[np.float32]:
    """An array as a kernel takes it."""
    return np.ascontiguousarray(array, dtype=np.float32).reshape(-1)


def shape_and_level(takes: str, gives: str, samples: int, mean: float, slope: float) -> Step:
    """A window over its own RMS, and ``(ln(RMS) - mean) * slope`` behind it."""
    constants: Constants = {"samples": samples, "mean": mean, "slope": slope}
    return Step("shape_and_level", (takes,), gives, samples + 1, constants, 10 * samples + 250)


def rbf(takes: str, gives: str, vectors: Real, gamma: float) -> Step:
    """``exp(-gamma |x - v|²)`` for each row v of ``vectors``, shape (vectors, inputs)."""
    wide = vectors.astype(np.float64)
    n, inputs = wide.shape
    constants: Constants = {
        "vectors": n,
        "inputs": inputs,
        "gamma": gamma,
        "steep": flat32(2 * gamma * wide),
        "norms": flat32(-gamma * (wide * wide).sum(axis=1)),
    }
    together = -(-n // 8) * 8
    cost = int(2.5 * together * inputs) + 45 * n + 1500
    return Step("rbf", (takes,), gives, n, constants, cost)


def dense(takes: str, gives: str, weight: Real, bias: Real) -> Step:
    """``weight @ x + bias``: weight (outputs, inputs), bias (outputs,)."""
    n, inputs = weight.shape
    own: Constants = {
        "outputs": n,
        "inputs": inputs,
        "weight": flat32(weight),
        "bias": flat32(bias),
    }
    return Step("dense", (takes,), gives, n, own, int(2.7 * weight.size) + 20 * n + 50)


def votes(takes: str, gives: str, classes: int) -> Step:
    """How many pairs each class wins: decisions in the order of ``itertools.combinations``.

    Above 0 the first of the pair wins, else the second.
    """
    return Step("votes", (takes,), gives, classes, {"classes": classes}, 8 * classes**2)


def given(takes: str, gives: str, values: Real) -> Step:
    """The same numbers, whatever comes in."""
    own: Constants = {"outputs": len(values), "values": flat32(values)}
    return Step("given", (takes,), gives, len(values), own, 10 + 4 * len(values))


def log_peak(takes: str, gives: str, samples: int) -> Step:
    """Logarithm of the largest magnitude, one number."""
    return Step("log_peak", (takes,), gives, 1, {"samples": samples}, 8 * samples + 100)


def parabola(takes: str, gives: str, powers: Real, low: float, high: float) -> Step:
    """``(a x + b) x + c`` of one number, held between ``low`` and ``high``."""
    a, b, c = (float(p) for p in powers)
    own: Constants = {"a": a, "b": b, "c": c, "low": low, "high": high}
    return Step("parabola", (takes,), gives, 1, own, 30)


def nearness(takes: str, gives: str, places: Real) -> Step:
    """``-|x - p|`` of one number to each place p."""
    own: Constants = {"outputs": len(places), "places": flat32(places)}
    return Step("nearness", (takes,), gives, len(places), own, 10 + 8 * len(places))


def deviation(takes: str, gives: str, lower: Real, most: float, least: float, scale: float) -> Step:
    """``scale sqrt(max(most - |L x|², least))`` of a lower triangular L, shape (n, n), one number.

    What a Gaussian process says of its own answer.
    """
    n = len(lower)
    packed = flat32(lower[np.tril_indices(n)])
    own: Constants = {"inputs": n, "lower": packed, "most": most, "least": least, "scale": scale}
    return Step("deviation", (takes,), gives, 1, own, 5 * n * n // 2 + 20 * n)
