"""The network as an ONNX graph, built from its weights.

A model file holds weights only and the graph is made here, so no graph that
came with a file is ever run: no foreign operators, no references to other files.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from firstcontact.core import InputError
from firstcontact.stiffness import architecture
from firstcontact.stiffness.spec import Arrays

#: Old enough for every ONNX Runtime that we allow.
OPSET, IR_VERSION = 18, 9
_SPATIAL = np.array([2, 3], dtype=np.int64)


class _Builder:
    """Appends operators to a chain of values."""

    def __init__(self, weights: Arrays) -> None:
        from onnx import helper, numpy_helper

        self._helper, self._from_array = helper, numpy_helper.from_array
        self._weights = weights
        self.nodes: list[Any] = []
        self.constants = {"spatial": self._from_array(_SPATIAL, "spatial")}

    def op(self, kind: str, *inputs: str, **attributes: Any) -> str:
        """Append an operator; gives the name of its output."""
        output = f"v{len(self.nodes)}"
        self.nodes.append(self._helper.make_node(kind, list(inputs), [output], **attributes))
        return output

    def weight(self, name: str, shape: tuple[int, ...]) -> str:
        """A weight of this shape, or InputError."""
        array = self._weights.get(name)
        if array is None or array.shape != shape or array.dtype != np.float32:
            raise InputError(
                f"the weight {name} of the CNN is missing or of another network: train it again"
            )
        self.constants[name] = self._from_array(np.ascontiguousarray(array), name)
        return name

    def conv(
        self,
        x: str,
        name: str,
        shape: tuple[int, int, int],
        stride: int = 1,
        groups: int = 1,
        linear: bool = False,
    ) -> str:
        """Convolution (outputs, inputs, kernel), and SiLU unless ``linear``."""
        outputs, inputs, kernel = shape
        weight = self.weight(f"{name}.weight", (outputs, inputs // groups, 1, kernel))
        out = self.op(
            "Conv",
            x,
            weight,
            self.weight(f"{name}.bias", (outputs,)),
            kernel_shape=[1, kernel],
            strides=[1, stride],
            pads=[0, kernel // 2, 0, kernel // 2],
            group=groups,
        )
        return out if linear else self.silu(out)

    def silu(self, x: str) -> str:
        """SiLU: x times its sigmoid."""
        return self.op("Mul", x, self.op("Sigmoid", x))

    def linear(self, x: str, name: str, outputs: int, inputs: int) -> str:
        """A fully connected layer."""
        weight = self.weight(f"{name}.weight", (outputs, inputs))
        return self.op("Gemm", x, weight, self.weight(f"{name}.bias", (outputs,)), transB=1)

    def squeeze_excitation(self, x: str, name: str, channels: int, squeezed: int) -> str:
        """Channels weighed by their mean over the window, as 1 x 1 convolutions."""
        pooled = self.op("ReduceMean", x, "spatial", keepdims=0)
        hidden = self.silu(self.linear(pooled, f"{name}.squeeze", squeezed, channels))
        gate = self.op("Sigmoid", self.linear(hidden, f"{name}.excite", channels, squeezed))
        return self.op("Mul", x, self.op("Unsqueeze", gate, "spatial"))

    def block(self, x: str, name: str, block: architecture.Block) -> str:
        """Fused-MBConv or MBConv."""
        k, wide = architecture.KERNEL, block.wide
        if block.fused and wide == block.inputs:
            out = self.conv(x, f"{name}.0", (block.outputs, wide, k), block.stride)
        elif block.fused:
            out = self.conv(x, f"{name}.0", (wide, block.inputs, k), block.stride)
            out = self.conv(out, f"{name}.1", (block.outputs, wide, 1), linear=True)
        else:
            out = self.conv(x, f"{name}.0", (wide, block.inputs, 1))
            out = self.conv(out, f"{name}.1", (wide, wide, k), block.stride, groups=wide)
            out = self.squeeze_excitation(out, f"{name}.2", wide, block.squeezed)
            out = self.conv(out, f"{name}.3", (block.outputs, wide, 1), linear=True)
        return self.op("Add", x, out) if block.shortcut else out


def build(weights: Arrays, samples: int, channels: int, outputs: int) -> bytes:
    """The graph: windows (n, channels, 1, samples) to answers (n, outputs).

    Parameters
    ----------
    weights
        As :meth:`efficientnet.EfficientNet.weights` gives them.
    samples, channels
        Of a window.
    outputs
        1 for regression, otherwise the number of classes.

    Returns
    -------
    bytes
        A serialised ONNX model.

    Raises
    ------
    InputError
        If a weight is missing or has another shape.
    """
    from onnx import TensorProto, helper

    builder = _Builder(weights)
    a = architecture
    x = builder.conv("window", "stem", (a.STEM, channels, a.STEM_KERNEL), a.STEM_STRIDE)
    for number, block in enumerate(a.blocks()):
        x = builder.block(x, f"blocks.{number}.layers", block)
    x = builder.conv(x, "head", (a.HEAD, a.STAGES[-1].channels, 1))
    x = builder.op("ReduceMean", x, "spatial", keepdims=0)
    x = builder.linear(x, "last", outputs, a.HEAD)
    made = helper.make_model(
        helper.make_graph(
            builder.nodes,
            "efficientnetv2_1d",
            [
                helper.make_tensor_value_info(
                    "window", TensorProto.FLOAT, ["n", channels, 1, samples]
                )
            ],
            [helper.make_tensor_value_info(x, TensorProto.FLOAT, ["n", outputs])],
            list(builder.constants.values()),
        ),
        opset_imports=[helper.make_opsetid("", OPSET)],
        ir_version=IR_VERSION,
    )
    serialised: bytes = made.SerializeToString()
    return serialised
