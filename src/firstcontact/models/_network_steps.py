"""Steps of the convolutional network, read from the graph in a model file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError, Step
from firstcontact.core import layer_steps as layers
from firstcontact.core.steps import dense

#: Length and channels of each vector. A vector without samples has length 1.
Shape = tuple[int, int]


class NetworkSteps:
    """Converter from a graph to steps, node by node."""

    def __init__(self, raw: bytes, samples: int, channels: int, compressed: str) -> None:
        from onnx import ModelProto, numpy_helper

        model = ModelProto()
        model.ParseFromString(raw)
        graph = model.graph
        self.steps: list[Step] = []
        self._constants = {t.name: numpy_helper.to_array(t) for t in graph.initializer}
        self._vectors = {graph.input[0].name: compressed}
        self._shapes: dict[str, Shape] = {graph.input[0].name: (samples, channels)}
        #: Inputs of logistic functions, by the name of the output. Each is merged into the step of
        #: the product that follows it.
        self._logistic: dict[str, str] = {}
        for node in graph.node:
            self._known[node.op_type](self, node)
        #: Name of the output vector.
        self.output = self._vectors[graph.output[0].name]

    def _add(self, node: Any, make: Callable[[str], Step], shape: Shape) -> None:
        """Add the step of a node."""
        gives = f"layer{len(self.steps)}"
        self.steps.append(make(gives))
        self._vectors[node.output[0]], self._shapes[node.output[0]] = gives, shape

    def _conv(self, node: Any) -> None:
        attributes = {a.name: list(a.ints) or a.i for a in node.attribute}
        weight: NDArray[Any] = self._constants[node.input[1]][:, :, 0, :]
        bias = self._constants[node.input[2]]
        takes, (samples, channels) = self._vectors[node.input[0]], self._shapes[node.input[0]]
        stride, group, taps = attributes["strides"][-1], attributes.get("group", 1), weight.shape[2]
        plain = attributes.get("pads") == [0, taps // 2, 0, taps // 2] and taps % 2 == 1
        plain &= set(attributes.get("dilations", [1])) == {1} and group in (1, channels)
        _require(plain and (group == 1 or len(weight) == channels))
        shape = (samples - 1) // stride + 1, len(weight)
        if group == 1:
            self._add(node, lambda to: layers.conv(takes, to, samples, weight, bias, stride), shape)
        else:
            kernels = weight[:, 0]
            self._add(
                node, lambda to: layers.depthwise(takes, to, samples, kernels, bias, stride), shape
            )

    def _gemm(self, node: Any) -> None:
        attributes = {a.name: a.f if a.type == a.FLOAT else a.i for a in node.attribute}
        _require(attributes.get("transB", 0) == 1 and attributes.get("transA", 0) == 0)
        _require({attributes.get("alpha", 1.0), attributes.get("beta", 1.0)} == {1.0})
        weight, bias = self._constants[node.input[1]], self._constants[node.input[2]]
        takes = self._vectors[node.input[0]]
        self._add(node, lambda to: dense(takes, to, weight, bias), (1, len(weight)))

    def _sigmoid(self, node: Any) -> None:
        self._logistic[node.output[0]] = node.input[0]
        self._shapes[node.output[0]] = self._shapes[node.input[0]]

    def _mul(self, node: Any) -> None:
        x, by = sorted(node.input, key=lambda name: name in self._logistic)
        _require(x not in self._logistic and by in self._logistic)
        logistic, (samples, channels) = self._logistic[by], self._shapes[x]
        takes = self._vectors[x]
        if logistic == x:
            size = samples * channels
            self._add(node, lambda to: layers.silu(takes, to, size), (samples, channels))
            return
        _require(self._shapes[logistic] == (1, channels))
        both = takes, self._vectors[logistic]
        self._add(node, lambda to: layers.gate(both, to, samples, channels), (samples, channels))

    def _plus(self, node: Any) -> None:
        first, second = node.input
        samples, channels = shape = self._shapes[first]
        _require(shape == self._shapes[second])
        both = self._vectors[first], self._vectors[second]
        self._add(node, lambda to: layers.plus(both, to, samples * channels), shape)

    def _mean(self, node: Any) -> None:
        samples, channels = self._shapes[node.input[0]]
        axes = sorted(int(a) % 4 for a in self._constants[node.input[1]])
        _require(axes == [2, 3])
        takes = self._vectors[node.input[0]]
        self._add(node, lambda to: layers.means(takes, to, samples, channels), (1, channels))

    def _unsqueeze(self, node: Any) -> None:
        """Only rename the vector, because a vector of channels already has length 1."""
        source, to = node.input[0], node.output[0]
        _require(self._shapes[source][0] == 1)
        self._shapes[to] = self._shapes[source]
        if source in self._logistic:
            self._logistic[to] = self._logistic[source]
        else:
            self._vectors[to] = self._vectors[source]

    _known: ClassVar[Mapping[str, Callable[[NetworkSteps, Any], None]]] = {
        "Conv": _conv,
        "Gemm": _gemm,
        "Sigmoid": _sigmoid,
        "Mul": _mul,
        "Add": _plus,
        "ReduceMean": _mean,
        "Unsqueeze": _unsqueeze,
    }


def _require(fulfilled: bool | np.bool_) -> None:
    if not fulfilled:
        raise InputError(
            "the CNN has layers that this program does not know, so the CNN cannot be exported: "
            "train it again"
        )
