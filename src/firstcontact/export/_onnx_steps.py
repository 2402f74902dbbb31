"""Steps of kernel machines and small models as ONNX nodes. Each row of an array is one window."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from firstcontact.core import Step


class Graph:
    """Builder of an ONNX graph: nodes and constants. Each row of an array is one window."""

    def __init__(self) -> None:
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def add(self, operator: str, takes: Sequence[str], gives: str = "", **attributes: Any) -> str:
        """Add a node. Return the name of its output."""
        from onnx import helper

        gives = gives or f"v{len(self.nodes)}"
        self.nodes.append(helper.make_node(operator, list(takes), [gives], **attributes))
        return gives

    def constant(self, values: Any, kind: Any = np.float32) -> str:
        """Add a constant. Return its name."""
        from onnx import numpy_helper

        name = f"c{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.asarray(values, dtype=kind), name))
        return name


def shape_and_level(g: Graph, s: Step) -> None:
    mean = g.add("ReduceMean", [g.add("Mul", [s.takes[0], s.takes[0]])], axes=[1], keepdims=1)
    rms = g.add("Sqrt", [mean])
    level = g.add("Sub", [g.add("Log", [rms]), g.constant(s.constants["mean"])])
    loud = g.add("Mul", [level, g.constant(s.constants["slope"])])
    g.add("Concat", [g.add("Div", [s.takes[0], rms]), loud], s.gives, axis=1)


def rbf(g: Graph, s: Step) -> None:
    c = s.constants
    steep = np.reshape(c["steep"], (int(c["vectors"]), int(c["inputs"])))
    near = g.add("Gemm", [s.takes[0], g.constant(steep), g.constant(c["norms"])], transB=1)
    square = g.add(
        "ReduceSum",
        [g.add("Mul", [s.takes[0], s.takes[0]]), g.constant([1], np.int64)],
        keepdims=1,
    )
    far = g.add("Mul", [square, g.constant(c["gamma"])])
    g.add("Exp", [g.add("Sub", [near, far])], s.gives)


def dense(g: Graph, s: Step) -> None:
    c = s.constants
    weight = np.reshape(c["weight"], (int(c["outputs"]), int(c["inputs"])))
    g.add("Gemm", [s.takes[0], g.constant(weight), g.constant(c["bias"])], s.gives, transB=1)


def votes(g: Graph, s: Step) -> None:
    k = int(s.constants["classes"])
    first, second = np.triu_indices(k, 1)
    won, lost = (np.eye(k)[indices] for indices in (first, second))
    above = g.add("Greater", [s.takes[0], g.constant(s.constants["least"])])
    share = g.add("Cast", [above], to=1)
    more = g.add("MatMul", [share, g.constant(won - lost)])
    g.add("Add", [more, g.constant(lost.sum(axis=0))], s.gives)


def log_peak(g: Graph, s: Step) -> None:
    peak = g.add("ReduceMax", [g.add("Abs", [s.takes[0]])], axes=[1], keepdims=1)
    g.add("Log", [peak], s.gives)


def parabola(g: Graph, s: Step) -> None:
    c = s.constants
    line = g.add("Mul", [s.takes[0], g.constant(c["a"])])
    slope = g.add("Add", [line, g.constant(c["b"])])
    value = g.add("Add", [g.add("Mul", [slope, s.takes[0]]), g.constant(c["c"])])
    g.add("Clip", [value, g.constant(c["low"]), g.constant(c["high"])], s.gives)


def nearness(g: Graph, s: Step) -> None:
    away = g.add("Sub", [s.takes[0], g.constant(s.constants["places"])])
    g.add("Neg", [g.add("Abs", [away])], s.gives)


def given(g: Graph, s: Step) -> None:
    none = g.add("Mul", [s.takes[0], g.constant(0.0)])
    nothing = g.add("ReduceSum", [none, g.constant([1], np.int64)], keepdims=1)
    g.add("Add", [nothing, g.constant(np.reshape(s.constants["values"], (1, -1)))], s.gives)


def deviation(g: Graph, s: Step) -> None:
    c = s.constants
    n = int(c["inputs"])
    lower = np.zeros((n, n), np.float32)
    lower[np.tril_indices(n)] = c["lower"]
    projected = g.add("MatMul", [s.takes[0], g.constant(lower.T)])
    squares = g.add("Mul", [projected, projected])
    explained = g.add("ReduceSum", [squares, g.constant([1], np.int64)], keepdims=1)
    left = g.add("Sub", [g.constant(c["most"]), explained])
    root = g.add("Sqrt", [g.add("Max", [left, g.constant(c["least"])])])
    g.add("Mul", [root, g.constant(c["scale"])], s.gives)
