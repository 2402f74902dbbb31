"""Steps of convolutional networks; each has a kernel in C of the same name.

A vector holds all channels of the first sample, then all of the next: what a convolution sees
of it lies side by side.
"""

from __future__ import annotations

from firstcontact.core._program import Constants, Step
from firstcontact.core.steps import Real, flat32

#: Instructions of a convolution that takes so many samples at once: once, for four outputs, and for
#: each number that these are made of.
_CONV = {1: (100, 17, 11), 4: (70, 61, 26.2), 5: (76, 76, 32)}


def compress(takes: str, gives: str, size: int, each: float, mean: float, slope: float) -> Step:
    """``(asinh(x * each) - mean) * slope`` of each number."""
    own: Constants = {"size": size, "each": each, "mean": mean, "slope": slope}
    return Step("compress", (takes,), gives, size, own, 54 * size + 60)


def conv(takes: str, gives: str, samples: int, weight: Real, bias: Real, stride: int) -> Step:
    """A convolution over ``samples``, zeros around them: weight (outputs, inputs, odd taps)."""
    outputs, inputs, taps = weight.shape
    there = _length(samples, stride)
    own: Constants = {
        "samples": samples,
        "inputs": inputs,
        "outputs": outputs,
        "taps": taps,
        "stride": stride,
        "weight": flat32(weight.transpose(0, 2, 1)),
        "bias": flat32(bias),
    }
    cost = _conv_cost(samples, inputs, outputs, taps, stride)
    return Step("conv", (takes,), gives, there * outputs, own, cost)


def _conv_cost(samples: int, inputs: int, outputs: int, taps: int, stride: int) -> int:
    """Samples are taken in fours and fives, four outputs at once, and those at the ends alone."""
    fours, others = divmod(outputs, 4)
    reach = taps // 2
    whole = (samples - taps + reach) // stride + 1  # outputs before this one meet all taps
    cost, t = 90.0, 0
    while t < _length(samples, stride):
        start = t * stride - reach
        seen = inputs * (min(samples - start, taps) - max(-start, 0))
        left = 0 if start < 0 else whole - t
        many = 5 if left > 4 and left % 4 else 4 if left >= 4 else 1
        block, group, each = _CONV[many]
        cost += block + fours * (group + each * seen) + others * many * (19 + 5 * seen)
        t += many
    return round(cost)


def depthwise(takes: str, gives: str, samples: int, weight: Real, bias: Real, stride: int) -> Step:
    """A convolution of each channel for itself: weight (channels, odd taps)."""
    channels, taps = weight.shape
    there = _length(samples, stride)
    own: Constants = {
        "samples": samples,
        "channels": channels,
        "taps": taps,
        "stride": stride,
        "weight": flat32(weight.T),
        "bias": flat32(bias),
    }
    size = there * channels
    once = 15 * channels + 43 if taps == 3 else taps * (7 * channels + 18) + 5 * channels + 40
    cost = there * once + 8 * channels + 130
    return Step("depthwise", (takes,), gives, size, own, cost)


def silu(takes: str, gives: str, size: int) -> Step:
    """``x / (1 + exp(-x))`` of each number."""
    return Step("silu", (takes,), gives, size, {"size": size}, 25 * size + 50)


def gate(takes: tuple[str, str], gives: str, samples: int, channels: int) -> Step:
    """The first vector, each channel times the logistic function of a number of the second."""
    own: Constants = {"samples": samples, "channels": channels}
    cost = (6 * channels + 10) * samples + 30 * channels + 40
    return Step("gate", takes, gives, samples * channels, own, cost)


def plus(takes: tuple[str, str], gives: str, size: int) -> Step:
    """The sum of two vectors."""
    return Step("plus", takes, gives, size, {"size": size}, 6 * size + 20)


def means(takes: str, gives: str, samples: int, channels: int) -> Step:
    """Mean of each channel over the samples."""
    own: Constants = {"samples": samples, "channels": channels}
    return Step("means", (takes,), gives, channels, own, (6 * samples + 13) * channels + 30)


def _length(samples: int, stride: int) -> int:
    return (samples - 1) // stride + 1
