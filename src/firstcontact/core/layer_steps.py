"""Steps of convolutional networks; each has a kernel in C of the same name.

A vector holds all channels of the first sample, then all of the next: what a convolution sees
of it lies side by side.
"""

from __future__ import annotations

from firstcontact.core.program import Constants, Step
from firstcontact.core.steps import Real, flat32


def compress(takes: str, gives: str, size: int, each: float, mean: float, slope: float) -> Step:
    """``(asinh(x * each) - mean) * slope`` of each number."""
    own: Constants = {"size": size, "each": each, "mean": mean, "slope": slope}
    return Step("compress", (takes,), gives, size, own, 75 * size)


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
    size = there * outputs
    return Step("conv", (takes,), gives, size, own, int(1.7 * there * weight.size) + 7 * size)


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
    return Step("depthwise", (takes,), gives, size, own, 5 * taps * size)


def silu(takes: str, gives: str, size: int) -> Step:
    """``x / (1 + exp(-x))`` of each number."""
    return Step("silu", (takes,), gives, size, {"size": size}, 26 * size)


def gate(takes: tuple[str, str], gives: str, samples: int, channels: int) -> Step:
    """The first vector, each channel times the logistic function of a number of the second."""
    own: Constants = {"samples": samples, "channels": channels}
    return Step("gate", takes, gives, samples * channels, own, (32 + 6 * samples) * channels)


def plus(takes: tuple[str, str], gives: str, size: int) -> Step:
    """The sum of two vectors."""
    return Step("plus", takes, gives, size, {"size": size}, 6 * size + 10)


def means(takes: str, gives: str, samples: int, channels: int) -> Step:
    """Mean of each channel over the samples."""
    own: Constants = {"samples": samples, "channels": channels}
    return Step("means", (takes,), gives, channels, own, (5 * samples + 20) * channels)


def _length(samples: int, stride: int) -> int:
    return (samples - 1) // stride + 1
