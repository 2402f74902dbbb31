"""Steps for features of a window's shape, as ONNX nodes. Each row of an array is one window."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from firstcontact.core import Step
from firstcontact.export._onnx_layers import by_sample
from firstcontact.export._onnx_steps import Graph

_DOUBLE, _FLOAT = 11, 1


def over_peak(g: Graph, s: Step) -> None:
    """Write :func:`firstcontact.core.shape_steps.over_peak` as ONNX."""
    peak = g.add("ReduceMax", [g.add("Abs", [s.takes[0]])], axes=[1], keepdims=1)
    g.add("Div", [s.takes[0], peak], s.gives)


def powers(g: Graph, s: Step) -> None:
    """Write :func:`firstcontact.core.shape_steps.powers` as ONNX."""
    lines = int(s.constants["lines"])
    squares = g.add("Mul", [s.takes[0], s.takes[0]])
    parts = by_sample(g, squares, 2, lines)
    g.add("ReduceSum", [parts, g.constant([1], np.int64)], s.gives, keepdims=0)


def level_free(g: Graph, s: Step) -> None:
    """Write :func:`firstcontact.core.shape_steps.level_free` as ONNX."""
    total = g.add("ReduceSum", [s.takes[0], g.constant([1], np.int64)], keepdims=1)
    share = g.add("Div", [s.takes[0], total])
    logs = g.add("Log", [g.add("Add", [share, g.constant(s.constants["floor"])])])
    g.add("Sub", [logs, g.add("ReduceMean", [logs], axes=[1], keepdims=1)], s.gives)


def course(g: Graph, s: Step) -> None:
    """Write :func:`firstcontact.core.shape_steps.course` as ONNX, in double precision."""
    c = s.constants
    n, one = int(c["samples"]), g.constant([1], np.int64)
    wide = g.add("Cast", [s.takes[0]], to=_DOUBLE)
    peak = g.add("ReduceMax", [g.add("Abs", [wide])], axes=[1], keepdims=1)
    every = by_sample(g, g.add("Div", [wide, peak]), n, int(c["channels"]))
    v = g.add("Gather", [every, g.constant(int(c["channel"]), np.int64)], axis=2)
    energy = g.add("CumSum", [g.add("Mul", [v, v]), g.constant(1, np.int64)])
    ends = [g.constant(k, np.int64) for k in ([0], [n - 1], [1], [n])]
    total = g.add("Slice", [energy, ends[1], ends[3], one])
    parts = []
    for quantile in np.asarray(c["quantile"]):
        level = g.add("Mul", [total, g.constant(quantile, np.float64)])
        parts.append(_share(g, g.add("Less", [energy, level])))
    earlier, later = (g.add("Slice", [v, a, b, one]) for a, b in (ends[:2], ends[2:]))
    signs = [g.add("Sign", [x]) for x in (earlier, later)]
    parts.append(_share(g, g.add("Not", [g.add("Equal", signs)])))
    step = g.add("Sub", [later, earlier])
    rough = g.add("ReduceSum", [g.add("Mul", [step, step]), one], keepdims=1)
    rough = g.add("Max", [rough, g.constant(1e-300, np.float64)])
    parts.append(g.add("Cast", [g.add("Log", [g.add("Div", [rough, total])])], to=_FLOAT))
    at = g.add("Cast", [g.add("ArgMax", [g.add("Abs", [v])], axis=1)], to=_FLOAT)
    parts.append(g.add("Div", [at, g.constant(n)]))
    g.add("Concat", parts, s.gives, axis=1)


def _share(g: Graph, condition: str) -> str:
    return g.add("ReduceMean", [g.add("Cast", [condition], to=_FLOAT)], axes=[1], keepdims=1)


def shares_above(g: Graph, s: Step) -> None:
    """Write :func:`firstcontact.core.shape_steps.shares_above` as ONNX."""
    c = s.constants
    n, channels, each = int(c["samples"]), int(c["channels"]), int(c["each"])
    square = g.add("Mul", [s.takes[0], s.takes[0]])
    rms = g.add("Sqrt", [g.add("ReduceMean", [square], axes=[1], keepdims=1)])
    waves, level = g.add("Div", [s.takes[0], rms]), g.add("Log", [rms])
    turned = g.add("Transpose", [by_sample(g, waves, n, channels)], perm=[0, 2, 1])
    wave = by_sample(g, turned, 1, n * channels)
    kernels = np.full((84, 1, 9), -1.0)
    np.put_along_axis(kernels[:, 0], np.array(list(combinations(range(9), 3))), 2.0, axis=1)
    weight, parts = g.constant(kernels), []
    biases = np.reshape(c["bias"], (-1, 84, each, 1))
    for dilation, bias in zip(np.asarray(c["dilation"]), biases, strict=True):
        reach = 4 * int(dilation)
        heard = g.add("Conv", [wave, weight], dilations=[int(dilation)], pads=[reach, reach])
        wide = g.add("Unsqueeze", [heard, g.constant([2], np.int64)])
        above = g.add("Cast", [g.add("Greater", [wide, g.constant(bias)])], to=_FLOAT)
        share = g.add("ReduceMean", [above], axes=[3], keepdims=0)
        parts.append(g.add("Flatten", [share], axis=1))
    g.add("Concat", [*parts, level], s.gives, axis=1)
