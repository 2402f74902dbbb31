"""The steps that models are described by; each has a kernel in C of the same name.

All make one vector, named ``gives``, from the vectors named in ``takes``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core._program import Constants, Step

Real = NDArray[Any]

#: Sums of squares of a window (V²) that its level is taken of: beyond them float32 holds no power,
#: or one with few digits left, and there is no answer.
LEAST_POWER, MOST_POWER = 1e-30, 1e38
#: Decision above which the first class of a pair wins. Kernel values below exp(-87) are 0 in C
#: and not in NumPy; whatever weighs them, they sum up to less than this, so that both choose the
#: same class where a pair's bias is 0.
LEAST_DECISION = 1e-30


def _rows(n: int, inputs: int) -> int:
    """Instructions of so many rows times a vector; rows are taken in eights, in fours, or alone."""
    many, each, begun = (8, 20, 54) if n >= 8 else (4, 11, 45) if n >= 4 else (1, 5, 30)
    return -(-n // many) * (each * inputs + begun) + 35


def flat32(array: Real) -> NDArray[np.float32]:
    """An array as a kernel takes it."""
    return np.ascontiguousarray(array, dtype=np.float32).reshape(-1)


def shape_and_level(takes: str, gives: str, samples: int, mean: float, slope: float) -> Step:
    """A window over its own RMS, and ``(ln(RMS) - mean) * slope`` behind it.

    The latter is NaN where the power is not between ``LEAST_POWER`` and ``MOST_POWER``.
    """
    constants: Constants = {
        "samples": samples,
        "mean": mean,
        "slope": slope,
        "least": LEAST_POWER,
        "most": MOST_POWER,
    }
    return Step("shape_and_level", (takes,), gives, samples + 1, constants, 10 * samples + 150)


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
    cost = _rows(n, inputs) + 31 * n + 5 * inputs + 40
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
    return Step("dense", (takes,), gives, n, own, _rows(n, inputs))


def votes(takes: str, gives: str, classes: int) -> Step:
    """How many pairs each class wins: decisions in the order of ``itertools.combinations``.

    Above ``LEAST_DECISION`` the first of the pair wins, else the second.
    """
    own: Constants = {"classes": classes, "least": LEAST_DECISION}
    cost = classes * (classes - 1) // 2 * 25 + 10 * classes + 40
    return Step("votes", (takes,), gives, classes, own, cost)


def given(takes: str, gives: str, values: Real) -> Step:
    """The same numbers, whatever comes in."""
    own: Constants = {"outputs": len(values), "values": flat32(values)}
    return Step("given", (takes,), gives, len(values), own, 20 + 4 * len(values))


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
    return Step("nearness", (takes,), gives, len(places), own, 20 + 8 * len(places))


def deviation(takes: str, gives: str, lower: Real, most: float, least: float, scale: float) -> Step:
    """``scale sqrt(max(most - |L x|², least))`` of a lower triangular L, shape (n, n), one number.

    What a Gaussian process says of its own answer.
    """
    n = len(lower)
    packed = flat32(lower[np.tril_indices(n)])
    own: Constants = {"inputs": n, "lower": packed, "most": most, "least": least, "scale": scale}
    return Step("deviation", (takes,), gives, 1, own, 3 * n * n + 13 * n + 50)
