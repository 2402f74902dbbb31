"""Exporter "onnx": graphs of convolutional networks, including the scaling of their signals."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from firstcontact.core import ModelError
from firstcontact.export.registry import ModelExporter
from firstcontact.models import Model
from firstcontact.models.windows.cnn import CnnModel


def to_onnx(model: CnnModel) -> bytes:
    """Return the ONNX graph of a CNN, as the bytes of a file.

    Its inputs are windows in V, shape (n, samples, channels), and its outputs are predictions.
    """
    from onnx import ModelProto, checker, helper, numpy_helper

    arrays, spec = model.to_arrays(), model.spec
    graph = ModelProto.FromString(model.graph)
    nodes, outputs = list(graph.graph.node), graph.graph.output[0]

    def node(operator: str, takes: list[Any], gives: str, **attributes: Any) -> Any:
        names = [take if isinstance(take, str) else f"{gives}.constant" for take in takes]
        for take in takes:
            if not isinstance(take, str):
                tensor = numpy_helper.from_array(np.asarray(take), f"{gives}.constant")
                graph.graph.initializer.append(tensor)
        return helper.make_node(operator, names, [gives], **attributes)

    amplitude, mean, deviation = arrays["scale"]
    before = [
        node("Transpose", ["volts"], "by_channel", perm=[0, 2, 1]),
        node("Unsqueeze", ["by_channel", np.array([2])], "rows"),
        node("Mul", ["rows", np.float32(1 / amplitude)], "relative"),
        node("Asinh", ["relative"], "compressed"),
        node("Sub", ["compressed", np.float32(mean)], "centred"),
        node("Mul", ["centred", np.float32(1 / deviation)], graph.graph.input[0].name),
    ]
    middle, scale = np.float32(model.target[0]), np.float32(model.target[1])
    after = [
        node("Mul", [outputs.name, scale], "scaled"),
        node("Add", ["scaled", middle], "prediction"),
    ]
    del graph.graph.node[:], graph.graph.input[:], graph.graph.output[:]
    graph.graph.node.extend([*before, *nodes, *after])
    shape = ["n", spec.samples, spec.channels]
    graph.graph.input.append(helper.make_tensor_value_info("volts", 1, shape))
    shape = ["n", len(spec.classes) or 1]
    graph.graph.output.append(helper.make_tensor_value_info("prediction", 1, shape))
    checker.check_model(graph)
    serialised: bytes = graph.SerializeToString(deterministic=True)
    return serialised


def write(model: Model, out: Path) -> list[str]:
    """Write one ONNX file for each CNN of a model into ``out``. Return notes for the user."""
    lines = []
    for window in model.windows:
        if not isinstance(window.model, CnnModel):
            continue
        length = f"_{1e3 * window.duration:.6g}ms".replace(".", "_")
        name = f"stiffness{length if len(model.windows) > 1 else ''}.onnx"
        raw = to_onnx(window.model)
        (out / name).write_bytes(raw)
        is_log = window.quantity.is_logarithmic and not window.classes
        unit = f", predicts the natural logarithm of {window.quantity.unit}" if is_log else ""
        lines.append(f"{name}: {len(raw)} bytes{unit}")
    if not lines:
        raise ModelError(
            "only a CNN can be written as ONNX, but this model has only "
            f"{', '.join(model.estimators) or 'a detector'}: use --to c"
        )
    return [*lines, "note: only the CNNs are written"]


ONNX = ModelExporter("onnx", write, "cnn", CnnModel.modules)
