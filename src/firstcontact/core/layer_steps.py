"""Steps of convolutional networks, for exported programs. Each has a C kernel with the same name.

A vector holds all channels of the first sample, then all channels of the next sample, and so on.
Thus the inputs of a convolution are adjacent.
"""

from __future__ import annotations

from firstcontact.core._program import Constants, Step
from firstcontact.core.steps import Real, flat32

#: Instructions of a convolution per block of 1, 4 or 5 samples: per block, per four outputs, and
#: per input value.
_CONV = {1: (100, 17, 11), 4: (70, 61, 26.2), 5: (76, 76, 32)}


def compress(takes: str, gives: str, size: int, each: float, mean: float, slope: float) -> Step:
    """Return the step that computes ``(asinh(x * each) - mean) * slope`` for each value x."""
    constants: Constants = {"size": size, "each": each, "mean": mean, "slope": slope}
    return Step("compress", (takes,), gives, size, constants, 54 * size + 60)


def conv(takes: str, gives: str, samples: int, weight: Real, bias: Real, stride: int) -> Step:
    """Return the step that convolves zero-padded channels."""
    outputs, inputs, taps = weight.shape
    length = _length(samples, stride)
    constants: Constants = {
        "samples": samples,
        "inputs": inputs,
        "outputs": outputs,
        "taps": taps,
        "stride": stride,
        "weight": flat32(weight.transpose(0, 2, 1)),
        "bias": flat32(bias),
    }
    cost = _conv_cost(samples, inputs, outputs, taps, stride)
    return Step("conv", (takes,), gives, length * outputs, constants, cost)


def _conv_cost(samples: int, inputs: int, outputs: int, taps: int, stride: int) -> int:
    """Return the number of instructions of :func:`conv`."""
    fours, rest_outputs = divmod(outputs, 4)
    reach = taps // 2
    full_outputs = (samples - taps + reach) // stride + 1  # outputs before this one use all taps
    cost, t = 90.0, 0
    while t < _length(samples, stride):
        start = t * stride - reach
        seen = inputs * (min(samples - start, taps) - max(-start, 0))
        left = 0 if start < 0 else full_outputs - t
        block_size = 5 if left > 4 and left % 4 else 4 if left >= 4 else 1
        block, group, each = _CONV[block_size]
        cost += block + fours * (group + each * seen) + rest_outputs * block_size * (19 + 5 * seen)
        t += block_size
    return round(cost)


def depthwise(takes: str, gives: str, samples: int, weight: Real, bias: Real, stride: int) -> Step:
    """Return the step that convolves each zero-padded channel with its own taps."""
    channels, taps = weight.shape
    length = _length(samples, stride)
    constants: Constants = {
        "samples": samples,
        "channels": channels,
        "taps": taps,
        "stride": stride,
        "weight": flat32(weight.T),
        "bias": flat32(bias),
    }
    size = length * channels
    per_sample = 15 * channels + 43 if taps == 3 else taps * (7 * channels + 18) + 5 * channels + 40
    cost = length * per_sample + 8 * channels + 130
    return Step("depthwise", (takes,), gives, size, constants, cost)


def silu(takes: str, gives: str, size: int) -> Step:
    """Return the step that computes ``x / (1 + exp(-x))`` for each value x."""
    return Step("silu", (takes,), gives, size, {"size": size}, 25 * size + 50)


def gate(takes: tuple[str, str], gives: str, samples: int, channels: int) -> Step:
    """Return the step that multiplies each channel of the first input by a factor."""
    constants: Constants = {"samples": samples, "channels": channels}
    cost = (6 * channels + 10) * samples + 30 * channels + 40
    return Step("gate", takes, gives, samples * channels, constants, cost)


def plus(takes: tuple[str, str], gives: str, size: int) -> Step:
    """Return the step that adds two vectors."""
    return Step("plus", takes, gives, size, {"size": size}, 6 * size + 20)


def means(takes: str, gives: str, samples: int, channels: int) -> Step:
    """Return the step that averages each channel over the samples."""
    constants: Constants = {"samples": samples, "channels": channels}
    return Step("means", (takes,), gives, channels, constants, (6 * samples + 13) * channels + 30)


def _length(samples: int, stride: int) -> int:
    return (samples - 1) // stride + 1
