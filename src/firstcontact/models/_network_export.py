"""Export of the CNN to ONNX, without PyTorch's exporter. Importing this module imports PyTorch.

PyTorch's exporter takes seconds in each process. So the package contains the graph that the
exporter made, and only the weights are filled in. After a change of the network, run ``python -m
firstcontact.models._network_export`` to make the graph again.
"""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib.resources import files
from pathlib import Path
from threading import RLock
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from tqdm import tqdm

from firstcontact.models._efficientnet import EfficientNet
from firstcontact.models._network import INPUT, OPSET

#: Graph of the network without weights.
GRAPH = Path(str(files("firstcontact.models").joinpath("efficientnet.onnx")))


def export(network: EfficientNet, samples: int) -> bytes:
    """Return the network as ONNX. It maps windows (n, channels, 1, samples) to outputs.

    Parameters
    ----------
    network
        Trained network.
    samples
        Number of samples in a window.

    Returns
    -------
    bytes
        A serialised ONNX model. The same weights and libraries give the same bytes.
    """
    folded = network.folded()
    weights = {name: tensor.detach().numpy() for name, tensor in folded.state_dict().items()}
    return _filled(samples, network.channels, network.last.out_features, weights)


def _filled(
    samples: int, channels: int, outputs: int, weights: Mapping[str, NDArray[np.float32]]
) -> bytes:
    """Return the shipped graph with these weights, given by their names in the folded network."""
    from onnx import ModelProto, numpy_helper

    model = ModelProto()
    model.CopyFrom(_graph())
    shape = model.graph.input[0].type.tensor_type.shape
    shape.dim[1].dim_value, shape.dim[3].dim_value = channels, samples
    model.graph.output[0].type.tensor_type.shape.dim[1].dim_value = outputs
    names = {tensor.name for tensor in model.graph.initializer}
    assert weights.keys() <= names, f"the graph lacks {sorted(weights.keys() - names)}"
    for tensor in model.graph.initializer:
        if tensor.name in weights:
            array = np.ascontiguousarray(weights[tensor.name])
            tensor.CopyFrom(numpy_helper.from_array(array, tensor.name))
    serialised: bytes = model.SerializeToString(deterministic=True)
    return serialised


@cache
def _graph() -> Any:
    """Return the graph that is shipped, for windows of any shape and any number of outputs."""
    from onnx import ModelProto

    return ModelProto.FromString(GRAPH.read_bytes())


def trace() -> Any:
    """Return the graph as PyTorch exports it, without the values of its weights."""
    with torch.random.fork_rng(devices=[]), _quiet():
        torch.manual_seed(0)
        network = EfficientNet(1, 1).folded()
        for parameter in network.parameters():
            torch.nn.init.normal_(parameter)  # equal tensors would become one
        exported = torch.onnx.export(
            network,
            (torch.zeros(2, 1, 1, 74),),
            input_names=[INPUT],
            output_names=["outputs"],
            opset_version=OPSET,
            dynamic_shapes=({0: torch.export.Dim("n"), 3: torch.export.Dim("samples")},),
            external_data=False,
            dynamo=True,
            verbose=False,
        )
    assert exported is not None
    model = exported.model_proto
    graph = model.graph
    # The exporter notes where in the source each operator comes from, with paths of this machine.
    for part in (model, graph, *graph.node, *graph.initializer, *graph.input, *graph.output):
        del part.metadata_props[:]
        part.ClearField("doc_string")
    del graph.value_info[:]
    names = set(network.state_dict())
    missing = names - {tensor.name for tensor in graph.initializer}
    assert not missing, f"the exporter renamed {sorted(missing)}"
    for tensor in graph.initializer:
        if tensor.name in names:
            tensor.ClearField("raw_data")
    return model


@contextmanager
def _quiet() -> Iterator[None]:
    """Suppress the exporter's messages on torchvision and on deprecations."""
    # PyTorch makes a progress bar that it never shows. Its lock is a semaphore between processes,
    # which would stay behind when a worker is ended. A lock between threads suffices here.
    tqdm.set_lock(RLock())
    log = logging.getLogger("torch.onnx")
    level = log.level
    log.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        log.setLevel(level)


if __name__ == "__main__":
    GRAPH.write_bytes(trace().SerializeToString(deterministic=True))
