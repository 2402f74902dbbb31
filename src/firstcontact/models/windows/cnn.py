"""Window model with a convolutional network, trained by PyTorch and run by ONNX Runtime."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.resources import files
from math import cos, pi, prod
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ModelError
from firstcontact.core.display import RED
from firstcontact.core.installation import import_onnxruntime
from firstcontact.models.estimator import Estimator, TrainingSet, target_scale, training_spec
from firstcontact.models.values import Task, Values, Windows
from firstcontact.models.windows.window_model import (
    TARGET,
    ArrayCheck,
    ModelFromArrays,
    Spec,
    WindowModel,
)

if TYPE_CHECKING:
    from torch import Tensor

    from firstcontact.models.windows.efficientnet import EfficientNet

#: Name of the input in the graph.
INPUT = "window"
#: Graph of the network as PyTorch exports it, without weights.
GRAPH = files("firstcontact.models.windows").joinpath("efficientnet.onnx")


def filled_graph(samples: int, channels: int, outputs: int, weights: NDArray[np.float32]) -> bytes:
    """Return the package's ONNX graph with these weights, as the bytes of an ONNX file.

    Its inputs have the shape (n, channels, 1, samples). Raise ModelError for a wrong number of
    weights.
    """
    from onnx import ModelProto, numpy_helper

    model = ModelProto.FromString(GRAPH.read_bytes())
    graph = model.graph
    shape = graph.input[0].type.tensor_type.shape
    shape.dim[1].dim_value, shape.dim[3].dim_value = channels, samples
    graph.output[0].type.tensor_type.shape.dim[1].dim_value = outputs
    start = 0
    for tensor in _weight_tensors(graph):
        sizes = list(tensor.dims)
        if tensor.name == "stem.0.weight":
            sizes[1] = channels
        elif tensor.name.startswith("last."):
            sizes[0] = outputs
        part = weights[start : start + prod(sizes)]
        start += prod(sizes)
        if start <= len(weights):
            tensor.CopyFrom(numpy_helper.from_array(part.reshape(sizes), tensor.name))
    if start != len(weights):
        raise ModelError(f"the CNN has {len(weights)} weights instead of {start}: train it again")
    serialised: bytes = model.SerializeToString(deterministic=True)
    return serialised


def _weight_tensors(graph: Any) -> list[Any]:
    from onnx import TensorProto

    return [tensor for tensor in graph.initializer if tensor.data_type == TensorProto.FLOAT]


def exported_weights(network: EfficientNet) -> NDArray[np.float32]:
    """Return the weights of a network in the order of the shipped graph, shape (weights,)."""
    from onnx import ModelProto

    folded = network.folded().state_dict()
    tensors = _weight_tensors(ModelProto.FromString(GRAPH.read_bytes()).graph)
    return np.concatenate([folded[tensor.name].detach().numpy().ravel() for tensor in tensors])


#: Number of windows for one call of ONNX Runtime. More only cost memory.
_BATCH = 256


def compress(X: NDArray[Any], scale: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return windows as inputs of the network: arcsinh of the windows over a typical amplitude.

    ``scale`` holds this amplitude (V), and the mean and standard deviation of the compressed
    values.
    """
    out: NDArray[np.float32] = np.arcsinh(X * np.float32(1.0 / scale[0]), dtype=np.float32)
    out -= np.float32(scale[1])
    out *= np.float32(1.0 / scale[2])
    return out


class CnnModel(ModelFromArrays):
    """Window model: an EfficientNetV2 for one dimension, exported from PyTorch."""

    kind: ClassVar[str] = "cnn"
    modules: ClassVar[tuple[str, ...]] = ("onnx", "onnxruntime")
    extra: ClassVar[str] = "cnn"

    declared: ClassVar[Mapping[str, ArrayCheck]] = {
        "scale": ArrayCheck((3,), positive=slice(0, 3, 2)),
        "target": TARGET,
        "training": ArrayCheck((2,)),
        "weights": ArrayCheck(("weights",)),
    }

    def __init__(self, spec: Spec, *arrays: NDArray[Any]) -> None:
        super().__init__(spec, *arrays)
        self._scale, _, self._training, weights = self._arrays.values()
        if self._training.min() < 0:
            raise ModelError("the CNN's field 'epochs' or 'batch' is below 0: train the CNN again")
        #: Network as ONNX. It maps compressed windows (n, channels, 1, samples) to outputs.
        self.graph = filled_graph(
            spec.samples, spec.channels, len(spec.classes) or 1, weights.astype(np.float32)
        )
        runtime = import_onnxruntime()
        options = runtime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = 4
        self._session = runtime.InferenceSession(
            self.graph, options, providers=["CPUExecutionProvider"]
        )

    @property
    def notes(self) -> Mapping[str, Any]:
        epochs, batch = self._training
        return {
            "epochs": int(epochs),
            "batch": int(batch),
            "parameters": len(self._arrays["weights"]),
            "amplitude_v": float(self._scale[0]),
        }

    def outputs(self, X: Windows) -> NDArray[np.float32]:
        windows = compress(X, self._scale).transpose(0, 2, 1)[:, :, None, :]
        parts = [
            self._session.run(None, {INPUT: np.ascontiguousarray(windows[i : i + _BATCH])})[0]
            for i in range(0, len(windows), _BATCH)
        ]
        width = len(self.spec.classes) or 1
        return np.concatenate(parts) if parts else np.zeros((0, width), dtype=np.float32)

    def __reduce__(self) -> tuple[Any, ...]:
        # A session of ONNX Runtime cannot be pickled, but the arrays that it is built from can.
        return type(self).from_arrays, (self.spec, self.to_arrays())


Inputs = NDArray[np.float32]

#: Largest learning rate of a one-cycle schedule, and the share of its steps in which it rises.
#: Smith and Topin: Super-Convergence, 2018 (arXiv:1708.07120).
LEARNING_RATE = 4e-3
RISE = 0.25
#: Largest batch, least number of batches in an epoch, and smallest batch, which takes precedence.
#: Small batches train better in few epochs, but the windows of a batch are normalised together.
BATCH = 64
STEPS = 16
SMALLEST = 8


@dataclass(frozen=True)
class Cnn(Estimator):
    """Estimator that trains an EfficientNetV2 for one dimension."""

    name: ClassVar[str] = "cnn"
    title: ClassVar[str] = "CNN"
    colour: ClassVar[str] = RED
    model: ClassVar[type[WindowModel]] = CnnModel
    slow: ClassVar[bool] = True
    folds: ClassVar[int] = 3
    together: ClassVar[int] = 3
    modules: ClassVar[tuple[str, ...]] = ("torch", *CnnModel.modules)
    extra: ClassVar[str] = CnnModel.extra
    quick: ClassVar[Mapping[str, Any]] = MappingProxyType({"epochs": 8})

    epochs: int = 12

    def fit(
        self, X: Windows, y: Values, groups: NDArray[Any] | None = None, seed: int = 0
    ) -> CnnModel:
        """Fit the network; see :meth:`Estimator.fit`. PyTorch's random state stays unchanged."""
        return self.fit_several([(X, y, groups)], seed)[0]

    def fit_several(self, sets: Sequence[TrainingSet], seed: int = 0) -> list[CnnModel]:
        """Train one network per training set; see :meth:`Estimator.fit_several`.

        Networks with equally many batches are trained together, which is faster.
        """
        prepared = [self._scale_data(*each) for each in sets]
        groups: dict[object, list[int]] = {}
        for place, (spec, *_, inputs, targets) in enumerate(prepared):
            steps = len(inputs) // _batch(len(inputs))
            key = spec.samples, spec.channels, targets.shape[1], _batch(len(inputs)), steps
            groups.setdefault(key, []).append(place)
        models: dict[int, CnnModel] = {}
        for places in groups.values():
            examples = [prepared[place][-2:] for place in places]
            networks = _train(examples, self.epochs, seed)
            for place, network in zip(places, networks, strict=True):
                spec, scale, target, inputs, _ = prepared[place]
                training = np.array([self.epochs, _batch(len(inputs))], dtype=np.float64)
                models[place] = CnnModel(spec, scale, target, training, exported_weights(network))
        return [models[place] for place in range(len(sets))]

    def _scale_data(
        self, X: Windows, y: Values, groups: NDArray[Any] | None
    ) -> tuple[Spec, NDArray[np.float64], NDArray[np.float64], Inputs, Inputs]:
        """Scale windows and targets for training.

        Return five values: specification of the model, scale of the windows, scale of the targets,
        scaled windows, and scaled targets, shape (n, outputs).
        """
        spec = training_spec(self.task, self.rate, X, y, groups)
        scale = _scale(X)
        target = target_scale(self.task, y)
        targets = (
            ((y - target[0]) / target[1])[:, None]
            if self.task is Task.REGRESSION
            else (y[:, None] == np.array(spec.classes))
        )
        return spec, scale, target, compress(X, scale), targets.astype(np.float32)


def _batch(n: int) -> int:
    return min(n, BATCH, max(SMALLEST, n // STEPS))


def _one_cycle(step: int, steps: int) -> float:
    """Return the learning rate at step ``step`` of ``steps``, as a share of the highest rate.

    The rate rises linearly, then falls as a cosine.
    """
    rise = max(1, round(RISE * steps))
    if step < rise:
        return (step + 1) / rise
    return 0.5 * (1.0 + cos(pi * (step - rise) / max(1, steps - rise)))


def _scale(X: Windows) -> NDArray[np.float64]:
    amplitude = float(np.median(np.sqrt((X.astype(np.float64) ** 2).mean(axis=(1, 2)))))
    compressed = np.arcsinh(X / amplitude)
    return np.array([amplitude, compressed.mean(), compressed.std()])


def as_input(inputs: NDArray[np.float32]) -> Tensor:
    """Return compressed windows (n, samples, channels) as a channels-last tensor."""
    import torch

    layout = np.ascontiguousarray(inputs.transpose(0, 2, 1))[:, :, None, :]
    return torch.from_numpy(layout).contiguous(memory_format=torch.channels_last)


def _train(examples: Sequence[tuple[Inputs, Inputs]], epochs: int, seed: int) -> list[EfficientNet]:
    """Train one network for each pair of inputs and targets, all in the same loop.

    The weights depend only on the data, the seed and the number of threads.
    """
    import torch

    from firstcontact.models.windows.efficientnet import EfficientNet, join, separate

    networks, orders = [], []
    for inputs, targets in examples:
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)
            networks.append(EfficientNet(inputs.shape[2], targets.shape[1]))
            orders.append([torch.randperm(len(inputs)) for _ in range(epochs)])
    trained = networks[0] if len(networks) == 1 else join(networks)
    trained.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    X = [as_input(inputs) for inputs, _ in examples]
    Y = [torch.from_numpy(targets) for _, targets in examples]
    optimiser = torch.optim.Adam(trained.parameters(), lr=LEARNING_RATE, fused=True)
    loss = torch.nn.MSELoss()
    # Windows that do not fill a batch are left out of an epoch: the normalisation needs whole
    # batches.
    batch = _batch(len(X[0]))
    steps = len(X[0]) // batch
    schedule = torch.optim.lr_scheduler.LambdaLR(
        optimiser, partial(_one_cycle, steps=epochs * steps)
    )
    for epoch in range(epochs):
        for start in range(0, steps * batch, batch):
            members = [order[epoch][start : start + batch] for order in orders]
            optimiser.zero_grad()
            windows = torch.cat([x[rows] for x, rows in zip(X, members, strict=True)], dim=1)
            truth = torch.cat([y[rows] for y, rows in zip(Y, members, strict=True)], dim=1)
            # The losses are added, so each network has the same gradient as when trained alone.
            (len(networks) * loss(trained(windows), truth)).backward()
            optimiser.step()
            schedule.step()
    if trained is not networks[0]:
        separate(trained, networks)
    return [network.eval() for network in networks]
