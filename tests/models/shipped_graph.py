"""Graph of the CNN as PyTorch exports it. After a change of the network, write it again:

python tests/models/shipped_graph.py
"""

import warnings
from pathlib import Path
from typing import Any

import torch

from firstcontact.models.windows.cnn import GRAPH, INPUT
from firstcontact.models.windows.efficientnet import EfficientNet


def traced_graph() -> Any:
    """Return the graph as PyTorch exports it, without the values of its weights."""
    with torch.random.fork_rng(devices=[]), warnings.catch_warnings(action="ignore"):
        torch.manual_seed(0)
        network = EfficientNet(1, 1).folded()
        for parameter in network.parameters():
            torch.nn.init.normal_(parameter)  # equal tensors would become one
        exported = torch.onnx.export(
            network,
            (torch.zeros(2, 1, 1, 74),),
            input_names=[INPUT],
            output_names=["outputs"],
            opset_version=18,
            dynamic_shapes=({0: torch.export.Dim("n"), 3: torch.export.Dim("samples")},),
            external_data=False,
            dynamo=True,
            verbose=False,
        )
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


if __name__ == "__main__":
    Path(str(GRAPH)).write_bytes(traced_graph().SerializeToString(deterministic=True))
