"""Steps that describe a window's shape; each has a kernel in C of the same name."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from firstcontact.core._program import Constants, Step
from firstcontact.core.steps import Real, flat32


def over_peak(takes: str, gives: str, size: int) -> Step:
    """Each number over the largest magnitude of all."""
    return Step("over_peak", (takes,), gives, size, {"size": size}, 13 * size + 60)


def powers(takes: str, gives: str, lines: int) -> Step:
    """Squared magnitudes of complex numbers: first all real parts, then all imaginary ones."""
    return Step("powers", (takes,), gives, lines, {"lines": lines}, 9 * lines + 20)


def level_free(takes: str, gives: str, size: int, floor: float) -> Step:
    """Logarithms of shares of the sum, ``floor`` added to each, their mean taken off."""
    own: Constants = {"size": size, "floor": floor}
    return Step("level_free", (takes,), gives, size, own, 47 * size + 60)


def course(
    takes: str, gives: str, samples: int, channels: int, channel: int, quantiles: Sequence[float]
) -> Step:
    """When the energy of a channel has come, turns of its sign, roughness, and when its peak is.

    ``takes`` is the window. As many numbers as there are quantiles, and three.
    """
    own: Constants = {
        "samples": samples,
        "channels": channels,
        "channel": channel,
        "quantiles": len(quantiles),
        "quantile": np.array(quantiles, np.float64),
    }
    count = samples * (39 + 9 * channels + 15 * len(quantiles)) + 20 * len(quantiles) + 150
    return Step("course", (takes,), gives, len(quantiles) + 3, own, count)


def shares_above(
    takes: str, gives: str, samples: int, channels: int, steps: Sequence[int], biases: Real
) -> Step:
    """MiniRocket's features: share of a window above biases after each of its 84 kernels.

    ``takes`` is the window; the logarithm of its RMS is the last number. Biases are of shape
    (steps, 84, each).
    """
    each = biases.shape[2]
    own: Constants = {
        "samples": samples,
        "channels": channels,
        "dilations": len(steps),
        "each": each,
        "dilation": np.array(steps, np.int32),
        "bias": flat32(biases),
    }
    once = len(steps) * (1510 + 925 * each) + 10
    count = once * samples * channels + 7 * biases.size + 150
    return Step("shares_above", (takes,), gives, biases.size + 1, own, count)
