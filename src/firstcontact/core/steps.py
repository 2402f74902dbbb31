"""Steps of which exported models consist. Each has a C kernel with the same name.

Each function returns a step. The step computes one vector, named ``gives``, from the vectors named
in ``takes``.

The docstring of a function describes the computation of its step. A kernel is the C function that
does this computation.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core._program import Constants, Step

Real = NDArray[Any]

#: Smallest and largest sum of squares of a window (V²). Outside them float32 holds too few digits
#: of the power, and the level is NaN.
LEAST_POWER, MOST_POWER = 1e-30, 1e38
#: Decision above which the first class of a pair wins. Kernel values below exp(-87) are 0 in C but
#: not in NumPy. Their weighted sum stays below this value, so both choose the same class even
#: if a pair's bias is 0.
LEAST_DECISION = 1e-30


def _rows(n: int, inputs: int) -> int:
    """Return the number of instructions for a matrix (n, inputs) times a vector (inputs,)."""
    rows, each, overhead = (8, 20, 54) if n >= 8 else (4, 11, 45) if n >= 4 else (1, 5, 30)
    return -(-n // rows) * (each * inputs + overhead) + 35


def flat32(array: Real) -> NDArray[np.float32]:
    """Return a flat float32 array, as kernels expect it."""
    return np.ascontiguousarray(array, dtype=np.float32).reshape(-1)


def shape_and_level(takes: str, gives: str, samples: int, mean: float, slope: float) -> Step:
    """Return the step that divides a window by its RMS, and appends one value for its level.

    The appended value is ``(ln(RMS) - mean) * slope``.

    It is NaN if the power is outside ``LEAST_POWER`` to ``MOST_POWER``.
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
    """Return the step that computes ``exp(-gamma |x - v|²)`` for each row v of ``vectors``."""
    wide = vectors.astype(np.float64)
    n, inputs = wide.shape
    constants: Constants = {
        "vectors": n,
        "inputs": inputs,
        "gamma": gamma,
        "steep": flat32(2 * gamma * wide),
        "norms": flat32(-gamma * (wide * wide).sum(axis=1)),
    }
    cost = _rows(n, inputs) + 36 * n + 5 * inputs + 40
    return Step("rbf", (takes,), gives, n, constants, cost)


def dense(takes: str, gives: str, weight: Real, bias: Real) -> Step:
    """Return the step that computes ``weight @ x + bias``."""
    n, inputs = weight.shape
    constants: Constants = {
        "outputs": n,
        "inputs": inputs,
        "weight": flat32(weight),
        "bias": flat32(bias),
    }
    return Step("dense", (takes,), gives, n, constants, _rows(n, inputs))


def votes(takes: str, gives: str, classes: int) -> Step:
    """Return the step that counts the votes for each class."""
    constants: Constants = {"classes": classes, "least": LEAST_DECISION}
    cost = classes * (classes - 1) // 2 * 25 + 10 * classes + 40
    return Step("votes", (takes,), gives, classes, constants, cost)


def given(takes: str, gives: str, values: Real) -> Step:
    """Return the step that gives constant values, independent of the input."""
    constants: Constants = {"outputs": len(values), "values": flat32(values)}
    return Step("given", (takes,), gives, len(values), constants, 20 + 4 * len(values))


def log_peak(takes: str, gives: str, samples: int) -> Step:
    """Return the step that computes the logarithm of the largest magnitude."""
    return Step("log_peak", (takes,), gives, 1, {"samples": samples}, 8 * samples + 100)


def parabola(takes: str, gives: str, powers: Real, low: float, high: float) -> Step:
    """Return the step that computes ``(a x + b) x + c`` for one value x, and clips the result."""
    a, b, c = (float(p) for p in powers)
    constants: Constants = {"a": a, "b": b, "c": c, "low": low, "high": high}
    return Step("parabola", (takes,), gives, 1, constants, 30)


def nearness(takes: str, gives: str, places: Real) -> Step:
    """Return the step that computes ``-|x - p|`` for a value x and each number p of ``places``."""
    constants: Constants = {"outputs": len(places), "places": flat32(places)}
    return Step("nearness", (takes,), gives, len(places), constants, 20 + 8 * len(places))


def deviation(takes: str, gives: str, lower: Real, most: float, least: float, scale: float) -> Step:
    """Return the step that computes ``scale sqrt(max(most - |L x|², least))``."""
    n = len(lower)
    packed = flat32(lower[np.tril_indices(n)])
    constants: Constants = {
        "inputs": n,
        "lower": packed,
        "most": most,
        "least": least,
        "scale": scale,
    }
    return Step("deviation", (takes,), gives, 1, constants, 3 * n * n + 13 * n + 50)
