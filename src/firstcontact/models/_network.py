"""Network from a file: checks of its graph, and its execution by ONNX Runtime on one thread."""

from __future__ import annotations

from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError, import_onnxruntime

#: Version of the operators, supported by every allowed ONNX Runtime.
OPSET = 18
#: Name of the input in the graph.
INPUT = "window"
#: Operators that this package's exporter uses. All others are refused.
OPERATORS = frozenset({"Add", "Conv", "Gemm", "Mul", "ReduceMean", "Sigmoid", "Unsqueeze"})
#: Largest graph, bytes (a trained one has 200 kB), largest number in an attribute, and largest size
#: of an intermediate value: _GROWTH times the window, plus _SMALL.
LARGEST = 1 << 20
_ATTRIBUTE = 1024
_GROWTH, _SMALL = 64, 4096


class Network:
    """ONNX graph that is checked before it runs.

    Parameters
    ----------
    raw
        A serialised ONNX model, from a file.
    samples, channels
        Shape of a window.
    outputs
        Number of outputs.

    Raises
    ------
    InputError
        The graph is not one that this program exports: it has another operator, a function, a
        reference to a file, another shape, or is too large.
    """

    def __init__(self, raw: bytes, samples: int, channels: int, outputs: int) -> None:
        runtime = import_onnxruntime()
        model = _checked(raw, (channels, 1, samples), outputs)
        #: Number of trained weights.
        self.parameters = sum(prod(t.dims) for t in model.graph.initializer if t.data_type == 1)
        options = runtime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = 4
        try:
            self._session = runtime.InferenceSession(
                model.SerializeToString(), options, providers=["CPUExecutionProvider"]
            )
            for n in (1, 2):
                got = self.run(np.zeros((n, channels, 1, samples), dtype=np.float32))
                _require(got.shape == (n, outputs), "the outputs have another shape")
        except InputError:
            raise
        except Exception:  # ONNX Runtime's errors have no common class
            raise _refusal("ONNX Runtime cannot run the network") from None

    def run(self, windows: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return outputs (n, outputs) for contiguous windows (n, channels, 1, samples)."""
        answers: NDArray[np.float32] = self._session.run(None, {INPUT: windows})[0]
        return answers


def _refusal(why: str) -> InputError:
    return InputError(f"the network of the CNN cannot be used ({why}): train it again")


def _require(fulfilled: bool, why: str) -> None:
    if not fulfilled:
        raise _refusal(why)


def _checked(raw: bytes, window: tuple[int, ...], outputs: int) -> Any:
    """Return the model after checks: only known operators, and bounded sizes."""
    from google.protobuf.message import DecodeError
    from onnx import ModelProto, checker, shape_inference

    _require(len(raw) <= LARGEST, f"the file has {len(raw)} bytes, more than {LARGEST}")
    model = ModelProto()
    try:
        model.ParseFromString(raw)
    except DecodeError:
        raise _refusal("the file is not an ONNX file") from None
    model.DiscardUnknownFields()
    graph = model.graph
    _require(
        [(o.domain, o.version) for o in model.opset_import] == [("", OPSET)]
        and not (model.functions or model.training_info or graph.sparse_initializer),
        "the file holds more than a graph of ONNX's own operators",
    )
    for node in graph.node:
        _require(
            node.domain == "" and node.op_type in OPERATORS,
            f"the file holds the operator {node.op_type[:40]!r}",
        )
        _require(
            all(map(_plain, node.attribute)),
            f"an attribute of the operator {node.op_type} is out of bounds",
        )
    for tensor in graph.initializer:
        _require(_is_intact(tensor), "a weight does not hold finite numbers in the graph itself")
    _require(
        _shapes(graph.input) == [(INPUT, "n", *window)]
        and [shape[1:] for shape in _shapes(graph.output)] == [("n", outputs)],
        "the network has other inputs or outputs than a CNN of this package",
    )
    try:
        checker.check_model(model)
        inferred = shape_inference.infer_shapes(model, check_type=True, strict_mode=True).graph
    except Exception:  # the checkers' errors have no common class
        raise _refusal("the parts do not fit together") from None
    most = _GROWTH * prod(window) + _SMALL
    sizes = {name: size for name, *size in [*_shapes(inferred.value_info), *_shapes(graph.output)]}
    for name in (name for node in graph.node for name in node.output):
        size = [d for d in sizes.get(name, [0]) if d != "n"]
        _require(
            all(isinstance(d, int) and d > 0 for d in size) and prod(size) <= most,
            "a value in it has no size or is too large",
        )
    return model


def _plain(attribute: Any) -> bool:
    """Return True if an attribute is text, or holds numbers within bounds."""
    kinds = type(attribute)
    numbers = [attribute.i, *attribute.ints]
    return attribute.type in (
        kinds.FLOAT,
        kinds.INT,
        kinds.INTS,
        kinds.STRING,
    ) and all(abs(number) <= _ATTRIBUTE for number in numbers)


def _is_intact(tensor: Any) -> bool:
    """Return True if a tensor is complete, of a known type, and finite."""
    from onnx import numpy_helper

    kinds = type(tensor)
    if tensor.data_location != kinds.DEFAULT or tensor.external_data:
        return False
    if tensor.data_type not in (kinds.FLOAT, kinds.INT64):
        return False
    try:
        return bool(np.isfinite(numpy_helper.to_array(tensor)).all())
    except (ValueError, TypeError):
        return False


def _shapes(values: Any) -> list[tuple[Any, ...]]:
    """Return the name and shape of each value, with ``n`` for the number of windows."""
    return [
        (v.name, *(d.dim_param or d.dim_value for d in v.type.tensor_type.shape.dim))
        for v in values
    ]
