"""Training of the convolutional network with PyTorch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import cos, pi
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import RED
from firstcontact.models._cnn_model import CnnModel, compress
from firstcontact.models._estimator import (
    Estimator,
    Reference,
    TrainingSet,
    target_scale,
    training_spec,
)
from firstcontact.models._spec import Spec, Task, Values, Windows
from firstcontact.models._window_model import WindowModel

if TYPE_CHECKING:
    from torch import Tensor

    from firstcontact.models._efficientnet import EfficientNet

Inputs = NDArray[np.float32]

#: Largest learning rate of a one-cycle schedule, and the share of its steps in which it rises.
#: Smith and Topin: Super-Convergence, 2018 (arXiv:1708.07120).
LEARNING_RATE = 4e-3
RISE = 0.25
#: Schedule of the paper: rate of Adam, epochs between halvings, and epochs in all.
PUBLISHED_RATE, HALVE_EVERY, PUBLISHED_EPOCHS = 1e-3, 5, 40
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
    published: bool = False

    def fit(
        self, X: Windows, y: Values, groups: NDArray[Any] | None = None, seed: int = 0
    ) -> CnnModel:
        """Fit the network; see :meth:`Estimator.fit`. PyTorch's random state stays unchanged."""
        return self._fit([(X, y, groups)], seed)[0]

    def fit_several(self, sets: Sequence[TrainingSet], seed: int = 0) -> Sequence[WindowModel]:
        """Fit several networks."""
        if type(self).fit is not Cnn.fit:  # a subclass trains in its own way
            return super().fit_several(sets, seed)
        return self._fit(sets, seed)

    def _fit(self, sets: Sequence[TrainingSet], seed: int) -> list[CnnModel]:
        from firstcontact.models._network_export import export

        epochs = PUBLISHED_EPOCHS if self.published else self.epochs
        prepared = [self._prepared(*each) for each in sets]
        groups: dict[object, list[int]] = {}
        for place, (spec, *_, inputs, targets) in enumerate(prepared):
            steps = len(inputs) // _batch(len(inputs))
            key = spec.samples, spec.channels, targets.shape[1], _batch(len(inputs)), steps
            groups.setdefault(key, []).append(place)
        models: dict[int, CnnModel] = {}
        for places in groups.values():
            examples = [prepared[place][-2:] for place in places]
            networks = _train(examples, epochs, self.published, seed)
            for place, network in zip(places, networks, strict=True):
                spec, scale, target, inputs, _ = prepared[place]
                training = np.array([epochs, _batch(len(inputs))], dtype=np.float64)
                onnx = np.frombuffer(export(network, spec.samples), dtype=np.uint8)
                models[place] = CnnModel(spec, scale, target, training, onnx)
        return [models[place] for place in range(len(sets))]

    def _prepared(
        self, X: Windows, y: Values, groups: NDArray[Any] | None
    ) -> tuple[Spec, NDArray[np.float64], NDArray[np.float64], Inputs, Inputs]:
        """Return specification, scales of windows and targets, and scaled inputs and targets."""
        spec = training_spec(self.task, self.rate, X, y, groups)
        scale = _scale(X)
        target = target_scale(self.task, y)
        targets = (
            ((y - target[0]) / target[1])[:, None]
            if self.task is Task.REGRESSION
            else (y[:, None] == np.array(spec.classes))
        )
        return spec, scale, target, compress(X, scale), targets.astype(np.float32)

    def reference(self, model: CnnModel, X: Windows, y: Values) -> Reference:
        """Return an equal network with random weights in PyTorch's eager mode, to time it."""
        import torch

        from firstcontact.models._efficientnet import EfficientNet

        network = EfficientNet(model.spec.channels, len(model.spec.classes) or 1).eval()
        network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]

        def predict(window: torch.Tensor) -> object:
            with torch.inference_mode():
                return network(window)

        compressed = compress(X, model.to_arrays()["scale"])
        return Reference("eager PyTorch", predict, [as_input(w[None]) for w in compressed])


def _batch(n: int) -> int:
    return min(n, BATCH, max(SMALLEST, n // STEPS))


def _one_cycle(step: int, steps: int) -> float:
    """Return the relative learning rate of a step: a linear rise, then half a cosine."""
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


def _train(
    examples: Sequence[tuple[Inputs, Inputs]], epochs: int, published: bool, seed: int
) -> list[EfficientNet]:
    """Train networks. The seed and the number of threads determine the weights."""
    import torch

    from firstcontact.models._efficientnet import EfficientNet
    from firstcontact.models._joined_network import join, separate

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
    rate = PUBLISHED_RATE if published else LEARNING_RATE
    optimiser = torch.optim.Adam(trained.parameters(), lr=rate, fused=True)
    loss = torch.nn.MSELoss()
    # Windows that do not fill a batch are left out of an epoch: the normalisation needs whole
    # batches.
    batch = _batch(len(X[0]))
    steps = len(X[0]) // batch
    halving = HALVE_EVERY * steps
    schedule = torch.optim.lr_scheduler.LambdaLR(
        optimiser,
        (lambda step: 0.5 ** (step // halving))
        if published
        else partial(_one_cycle, steps=epochs * steps),
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
