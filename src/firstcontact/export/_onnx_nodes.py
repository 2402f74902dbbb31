"""An ONNX graph as it grows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np


class Graph:
    """Nodes and constants as they are added; rows are windows."""

    def __init__(self) -> None:
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def add(self, operator: str, takes: Sequence[str], gives: str = "", **attributes: Any) -> str:
        """Add a node; what it gives."""
        from onnx import helper

        gives = gives or f"v{len(self.nodes)}"
        self.nodes.append(helper.make_node(operator, list(takes), [gives], **attributes))
        return gives

    def constant(self, values: Any, kind: Any = np.float32) -> str:
        """Add a constant; its name."""
        from onnx import numpy_helper

        name = f"c{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.asarray(values, dtype=kind), name))
        return name
