"""``--to onnx``: each model of a window as one ONNX graph, held against ONNX Runtime."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from firstcontact.core import InputError
from firstcontact.core.program import INPUT, Program, Step
from firstcontact.embedded.exporters import ModelExporter
from firstcontact.embedded.trained import NamedModel, Trained

OPSET = 17
#: Largest difference to Python's outputs that is let through, relative to the largest of them.
TOLERANCE = 1e-3


class Graph:
    """Nodes and constants as they are added; rows are windows."""

    def __init__(self) -> None:
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def add(self, operator: str, takes: Sequence[str], gives: str = "", **told: Any) -> str:
        """Add a node; what it gives."""
        from onnx import helper

        gives = gives or f"v{len(self.nodes)}"
        self.nodes.append(helper.make_node(operator, list(takes), [gives], **told))
        return gives

    def constant(self, values: Any, kind: Any = np.float32) -> str:
        """Add a constant; its name."""
        from onnx import numpy_helper

        name = f"c{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.asarray(values, dtype=kind), name))
        return name


def _shape_and_level(g: Graph, s: Step) -> None:
    mean = g.add("ReduceMean", [g.add("Mul", [s.takes[0], s.takes[0]])], axes=[1], keepdims=1)
    rms = g.add("Sqrt", [mean])
    level = g.add("Sub", [g.add("Log", [rms]), g.constant(s.constants["mean"])])
    loud = g.add("Mul", [level, g.constant(s.constants["slope"])])
    g.add("Concat", [g.add("Div", [s.takes[0], rms]), loud], s.gives, axis=1)


def _rbf(g: Graph, s: Step) -> None:
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


def _dense(g: Graph, s: Step) -> None:
    c = s.constants
    weight = np.reshape(c["weight"], (int(c["outputs"]), int(c["inputs"])))
    g.add("Gemm", [s.takes[0], g.constant(weight), g.constant(c["bias"])], s.gives, transB=1)


def _votes(g: Graph, s: Step) -> None:
    k = int(s.constants["classes"])
    first, second = np.triu_indices(k, 1)
    won, lost = (np.eye(k)[which] for which in (first, second))
    above = g.add("Greater", [s.takes[0], g.constant(0.0)])
    share = g.add("Cast", [above], to=1)
    more = g.add("MatMul", [share, g.constant(won - lost)])
    g.add("Add", [more, g.constant(lost.sum(axis=0))], s.gives)


def _log_peak(g: Graph, s: Step) -> None:
    peak = g.add("ReduceMax", [g.add("Abs", [s.takes[0]])], axes=[1], keepdims=1)
    g.add("Log", [peak], s.gives)


def _parabola(g: Graph, s: Step) -> None:
    c = s.constants
    line = g.add("Mul", [s.takes[0], g.constant(c["a"])])
    slope = g.add("Add", [line, g.constant(c["b"])])
    value = g.add("Add", [g.add("Mul", [slope, s.takes[0]]), g.constant(c["c"])])
    g.add("Clip", [value, g.constant(c["low"]), g.constant(c["high"])], s.gives)


def _nearness(g: Graph, s: Step) -> None:
    away = g.add("Sub", [s.takes[0], g.constant(s.constants["places"])])
    g.add("Neg", [g.add("Abs", [away])], s.gives)


def _given(g: Graph, s: Step) -> None:
    none = g.add("Mul", [s.takes[0], g.constant(0.0)])
    nothing = g.add("ReduceSum", [none, g.constant([1], np.int64)], keepdims=1)
    g.add("Add", [nothing, g.constant(np.reshape(s.constants["values"], (1, -1)))], s.gives)


def _deviation(g: Graph, s: Step) -> None:
    c = s.constants
    n = int(c["inputs"])
    lower = np.zeros((n, n), np.float32)
    lower[np.tril_indices(n)] = c["lower"]
    known = g.add("MatMul", [s.takes[0], g.constant(lower.T)])
    squares = g.add("Mul", [known, known])
    told = g.add("ReduceSum", [squares, g.constant([1], np.int64)], keepdims=1)
    left = g.add("Sub", [g.constant(c["most"]), told])
    root = g.add("Sqrt", [g.add("Max", [left, g.constant(c["least"])])])
    g.add("Mul", [root, g.constant(c["scale"])], s.gives)


#: How the kernels of steps are written; one that is not here is refused.
KERNELS: Mapping[str, Callable[[Graph, Step], None]] = {
    "shape_and_level": _shape_and_level,
    "rbf": _rbf,
    "dense": _dense,
    "votes": _votes,
    "log_peak": _log_peak,
    "parabola": _parabola,
    "nearness": _nearness,
    "given": _given,
    "deviation": _deviation,
}


def _inner(vector: str) -> str:
    """Name of a step's vector, which none of the graph's own has."""
    return vector if vector == INPUT else f"step.{vector}"


def to_onnx(program: Program) -> bytes:
    """A serialised graph: ``window`` (n, inputs) to ``outputs`` and, if it has one, ``spread``.

    Raises
    ------
    InputError
        A step that has no form in ONNX here.
    """
    from onnx import TensorProto, checker, helper

    graph = Graph()
    for step in program.steps:
        if step.kernel not in KERNELS:
            raise InputError(
                f"the step {step.kernel!r} of this model has no form in ONNX: use --to c"
            )
        takes = tuple(_inner(name) for name in step.takes)
        KERNELS[step.kernel](graph, replace(step, takes=takes, gives=_inner(step.gives)))
    names = {"outputs": program.output} | ({"spread": program.spread} if program.spread else {})
    for name, vector in names.items():
        graph.add("Identity", [_inner(vector)], name)
    taken = [helper.make_tensor_value_info(INPUT, TensorProto.FLOAT, ["n", program.inputs])]
    given = [
        helper.make_tensor_value_info(name, TensorProto.FLOAT, ["n", program.size(vector)])
        for name, vector in names.items()
    ]
    made = helper.make_graph(graph.nodes, "firstcontact", taken, given, graph.constants)
    model = helper.make_model(made, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=8)
    checker.check_model(model)
    serialised: bytes = model.SerializeToString(deterministic=True)
    return serialised


def checked(named: NamedModel, raw: bytes) -> float:
    """Largest difference of ONNX Runtime's outputs to Python's on drawn windows, relative.

    Raises
    ------
    InputError
        They are not the same.
    """
    from onnxruntime import InferenceSession

    spec = named.model.spec
    windows = np.random.default_rng(0).standard_normal((64, spec.samples, spec.channels))
    X = (0.1 * windows).astype(np.float32)
    session = InferenceSession(raw, providers=["CPUExecutionProvider"])
    (got,) = session.run(["outputs"], {INPUT: X.reshape(len(X), -1)})
    wanted = named.model.outputs(X)
    if spec.classes:
        wrong = float((named.model.choose(wanted) != got.argmax(axis=1)).mean())
    else:
        scale = max(1.0, float(np.abs(wanted).max()))
        wrong = float(np.abs(got[:, 0] - wanted[:, 0]).max()) / scale
    if not wrong <= TOLERANCE:
        raise InputError(f"{named.name}: ONNX Runtime answers otherwise ({wrong:g}): use --to c")
    return wrong


def write(trained: Trained, out: Path) -> list[str]:
    """Write the graphs; what there is to say."""
    if not trained.models:
        raise InputError(
            f"ONNX is written of models of a window, and none is here ({', '.join(trained.parts)}"
            "): use --to c"
        )
    lines = []
    for named in trained.models:
        raw = to_onnx(named.model.program())
        away = checked(named, raw)
        (out / f"{named.name}.onnx").write_bytes(raw)
        lines.append(f"{named.name}.onnx: {len(raw)} bytes, ONNX Runtime agrees to {away:.1g}")
    others = len(trained.parts) - len(trained.models)
    return lines + (
        ["note: detector and any-time model are left out: use --to c"] if others else []
    )


ONNX = ModelExporter("onnx", write, "cnn", ("onnx", "onnxruntime"))
