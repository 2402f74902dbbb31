"""Steps of convolutional networks as ONNX nodes. Each row of an array is one window."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Step
from firstcontact.export._onnx_steps import Graph


def compress(g: Graph, s: Step) -> None:
    """Write :func:`firstcontact.core.layer_steps.compress` as ONNX."""
    c = s.constants
    wave = g.add("Mul", [s.takes[0], g.constant(c["each"])])
    away = g.add("Sub", [g.add("Asinh", [wave]), g.constant(c["mean"])])
    g.add("Mul", [away, g.constant(c["slope"])], s.gives)


def conv(g: Graph, s: Step) -> None:
    """Write :func:`firstcontact.core.layer_steps.conv` as ONNX."""
    c = s.constants
    shape = int(c["outputs"]), int(c["taps"]), int(c["inputs"])
    weight = np.reshape(c["weight"], shape).transpose(0, 2, 1)
    _convolved(g, s, int(c["inputs"]), weight, 1)


def depthwise(g: Graph, s: Step) -> None:
    """Write :func:`firstcontact.core.layer_steps.depthwise` as ONNX."""
    c = s.constants
    channels = int(c["channels"])
    weight = np.reshape(c["weight"], (int(c["taps"]), channels)).T[:, None]
    _convolved(g, s, channels, weight, channels)


def _convolved(g: Graph, s: Step, channels: int, weight: NDArray[Any], group: int) -> None:
    c = s.constants
    reach = int(c["taps"]) // 2
    by_channel = by_sample(g, s.takes[0], int(c["samples"]), channels)
    convolved = g.add(
        "Conv",
        [
            g.add("Transpose", [by_channel], perm=[0, 2, 1]),
            g.constant(weight),
            g.constant(c["bias"]),
        ],
        strides=[int(c["stride"])],
        pads=[reach, reach],
        group=group,
    )
    back = g.add("Transpose", [convolved], perm=[0, 2, 1])
    g.add("Flatten", [back], s.gives, axis=1)


def silu(g: Graph, s: Step) -> None:
    """Write :func:`firstcontact.core.layer_steps.silu` as ONNX."""
    g.add("Mul", [s.takes[0], g.add("Sigmoid", [s.takes[0]])], s.gives)


def gate(g: Graph, s: Step) -> None:
    """Write :func:`firstcontact.core.layer_steps.gate` as ONNX."""
    samples, channels = int(s.constants["samples"]), int(s.constants["channels"])
    share = by_sample(g, g.add("Sigmoid", [s.takes[1]]), 1, channels)
    shut = g.add("Mul", [by_sample(g, s.takes[0], samples, channels), share])
    g.add("Flatten", [shut], s.gives, axis=1)


def plus(g: Graph, s: Step) -> None:
    """Write :func:`firstcontact.core.layer_steps.plus` as ONNX."""
    g.add("Add", s.takes, s.gives)


def means(g: Graph, s: Step) -> None:
    """Write :func:`firstcontact.core.layer_steps.means` as ONNX."""
    c = s.constants
    by_channel = by_sample(g, s.takes[0], int(c["samples"]), int(c["channels"]))
    g.add("ReduceMean", [by_channel], s.gives, axes=[1], keepdims=0)


def by_sample(g: Graph, vector: str, samples: int, channels: int) -> str:
    """Return flat vectors (n, samples * channels) reshaped to (n, samples, channels)."""
    return g.add("Reshape", [vector, g.constant([-1, samples, channels], np.int64)])
