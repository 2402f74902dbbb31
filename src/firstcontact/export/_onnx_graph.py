"""Export of window models as ONNX graphs, compared with ONNX Runtime."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from firstcontact.core import INPUT, InputError, Program, Step, import_onnxruntime
from firstcontact.export import _onnx_layers, _onnx_shapes, _onnx_steps
from firstcontact.export._exporters import ModelExporter
from firstcontact.export._onnx_steps import Graph
from firstcontact.export._trained import NamedModel, Trained

OPSET = 17
#: Largest accepted difference from Python's outputs, relative to the largest output.
TOLERANCE = 1e-3


#: Modules that write steps as ONNX. The function for a step has the name of the step's kernel. A
#: step without a function is refused.
FORMS = (_onnx_steps, _onnx_layers, _onnx_shapes)


def _form(kernel: str) -> Callable[[Graph, Step], None]:
    for module in FORMS:
        form: Callable[[Graph, Step], None] | None = getattr(module, kernel, None)
        if form is not None:
            return form
    raise InputError(
        f"the computation {kernel!r} of this model cannot be written as ONNX: use --to c"
    )


def _inner(vector: str) -> str:
    """Return a name for a step's vector that differs from the names of the graph's outputs."""
    return vector if vector == INPUT else f"step.{vector}"


def to_onnx(program: Program) -> bytes:
    """Return a program as a serialised ONNX graph."""
    from onnx import TensorProto, checker, helper

    graph = Graph()
    for step in program.steps:
        form = _form(step.kernel)
        takes = tuple(_inner(name) for name in step.takes)
        form(graph, replace(step, takes=takes, gives=_inner(step.gives)))
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
    """Return the largest difference between the outputs of ONNX Runtime and of Python."""
    spec = named.model.spec
    windows = np.random.default_rng(0).standard_normal((64, spec.samples, spec.channels))
    X = (0.1 * windows).astype(np.float32)
    session = import_onnxruntime().InferenceSession(raw, providers=["CPUExecutionProvider"])
    (got,) = session.run(["outputs"], {INPUT: X.reshape(len(X), -1)})
    wanted = named.model.outputs(X)
    if spec.classes:
        wrong = float((named.model.choose(wanted) != got.argmax(axis=1)).mean())
    else:
        scale = max(1.0, float(np.abs(wanted).max()))
        wrong = float(np.abs(got[:, 0] - wanted[:, 0]).max()) / scale
    if not wrong <= TOLERANCE:
        raise InputError(
            f"{named.name}: the outputs of ONNX Runtime differ from those of the model "
            f"({wrong:g}): use --to c"
        )
    return wrong


def write(trained: Trained, out: Path) -> list[str]:
    """Write one graph per window model into the folder. Return notes for the user."""
    if not trained.models:
        raise InputError(
            "only window models can be written as ONNX, and this model has none (its parts: "
            f"{', '.join(trained.parts)}): use --to c"
        )
    lines = []
    for named in trained.models:
        raw = to_onnx(named.model.program())
        away = checked(named, raw)
        (out / f"{named.name}.onnx").write_bytes(raw)
        lines.append(f"{named.name}.onnx: {len(raw)} bytes, ONNX Runtime agrees to {away:.1g}")
    left_out = len(trained.parts) - len(trained.models)
    return lines + (["note: detector and network are left out: use --to c"] if left_out else [])


ONNX = ModelExporter("onnx", write, "cnn", ("onnx", "onnxruntime"))
