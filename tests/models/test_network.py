"""Only the weights of an ONNX file are used, after checks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from onnx import ModelProto, StringStringEntryProto, TensorProto, helper, numpy_helper

from firstcontact.core import InputError
from firstcontact.models._cnn import LARGEST_GRAPH, CheckedGraph


def changed(raw: bytes, change: Callable[[Any], None]) -> bytes:
    model = ModelProto.FromString(raw)
    change(model)
    return model.SerializeToString()


def weight(model: Any, name: str = "stem.0.weight") -> Any:
    return next(t for t in model.graph.initializer if t.name == name)


def external(model: Any) -> None:
    tensor = weight(model)
    tensor.data_location = TensorProto.EXTERNAL
    tensor.external_data.append(StringStringEntryProto(key="location", value="/etc/passwd"))
    tensor.ClearField("raw_data")


def endless(model: Any) -> None:
    old = weight(model, "last.weight")
    old.CopyFrom(numpy_helper.from_array(np.full((1, 96), np.inf, np.float32), "last.weight"))


def cut_weight(model: Any) -> None:
    weight(model).raw_data = weight(model).raw_data[:-4]


def no_weight(model: Any) -> None:
    weight(model).name = "another"


def wrong_weight(model: Any) -> None:
    tensor = weight(model)
    tensor.CopyFrom(numpy_helper.from_array(np.zeros((16, 7, 1, 5), np.float32), tensor.name))


@pytest.mark.parametrize("change", [external, endless, cut_weight, no_weight, wrong_weight])
def test_weights_that_do_not_fit_are_refused(
    network_graph: bytes, change: Callable[[Any], None]
) -> None:
    with pytest.raises(InputError, match=r"^the network of the CNN cannot be used \(.*\): .*"):
        CheckedGraph(changed(network_graph, change), 74, 1, 1)


def foreign_graph(model: Any) -> None:
    del model.graph.node[2:]
    model.graph.node.append(helper.make_node("Loop", ["a"], ["b"]))
    model.opset_import.append(helper.make_opsetid("com.microsoft", 1))


def test_only_the_weights_of_a_file_are_used(network_graph: bytes) -> None:
    window = np.random.default_rng(0).normal(size=(3, 1, 1, 74)).astype(np.float32)
    original = CheckedGraph(network_graph, 74, 1, 1)
    foreign = CheckedGraph(changed(network_graph, foreign_graph), 74, 1, 1)
    np.testing.assert_array_equal(foreign.run(window), original.run(window))
    assert foreign.graph == network_graph


@pytest.mark.parametrize("raw", [b"", b"no ONNX", b"\x00" * 100, b"\xff" * 5000])
def test_what_is_no_graph_is_refused(raw: bytes) -> None:
    with pytest.raises(InputError, match="cannot be used"):
        CheckedGraph(raw, 74, 1, 1)


def test_a_huge_graph_is_not_parsed() -> None:
    with pytest.raises(InputError, match="more than 1048576"):
        CheckedGraph(bytes(LARGEST_GRAPH + 1), 74, 1, 1)


def test_bytes_that_were_damaged_are_refused_or_answer(network_graph: bytes) -> None:
    rng = np.random.default_rng(0)
    for _ in range(150):
        raw = bytearray(network_graph)
        location = rng.integers(len(raw) if rng.random() < 0.3 else 4000)
        raw[location] = rng.integers(256)
        try:
            network = CheckedGraph(bytes(raw), 74, 1, 1)
        except InputError:
            continue
        assert network.run(np.zeros((3, 1, 1, 74), dtype=np.float32)).shape == (3, 1)
