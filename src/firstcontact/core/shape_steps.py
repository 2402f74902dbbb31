"""Steps for features of a window's shape. Each has a C kernel with the same name.

Each function returns the step that does the computation.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from firstcontact.core._program import Constants, Step
from firstcontact.core.steps import Real, flat32


def over_peak(takes: str, gives: str, size: int) -> Step:
    """Return the step that divides each value by the largest magnitude of all values."""
    return Step("over_peak", (takes,), gives, size, {"size": size}, 13 * size + 60)


def powers(takes: str, gives: str, lines: int) -> Step:
    """Return the step that computes the squared magnitudes of complex numbers."""
    return Step("powers", (takes,), gives, lines, {"lines": lines}, 9 * lines + 20)


def level_free(takes: str, gives: str, size: int, floor: float) -> Step:
    """Return the step that computes ``ln(x / sum + floor)`` for each value x, minus their mean."""
    constants: Constants = {"size": size, "floor": floor}
    return Step("level_free", (takes,), gives, size, constants, 47 * size + 60)


def course(
    takes: str, gives: str, samples: int, channels: int, channel: int, quantiles: Sequence[float]
) -> Step:
    """Return the step for features of a signal's course: energy times, roughness and others."""
    constants: Constants = {
        "samples": samples,
        "channels": channels,
        "channel": channel,
        "quantiles": len(quantiles),
        "quantile": np.array(quantiles, np.float64),
    }
    count = samples * (39 + 9 * channels + 15 * len(quantiles)) + 20 * len(quantiles) + 150
    return Step("course", (takes,), gives, len(quantiles) + 3, constants, count)


def shares_above(
    takes: str, gives: str, samples: int, channels: int, steps: Sequence[int], biases: Real
) -> Step:
    """Return the step for the features of MiniRocket: shares of convolved values above biases."""
    each = biases.shape[2]
    constants: Constants = {
        "samples": samples,
        "channels": channels,
        "dilations": len(steps),
        "each": each,
        "dilation": np.array(steps, np.int32),
        "bias": flat32(biases),
    }
    per_value = len(steps) * (1510 + 925 * each) + 10
    count = per_value * samples * channels + 7 * biases.size + 150
    return Step("shares_above", (takes,), gives, biases.size + 1, constants, count)
