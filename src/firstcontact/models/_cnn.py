"""Trains the convolutional network with PyTorch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import RED
from firstcontact.models._cnn_model import CnnModel, compress
from firstcontact.models._estimator import Estimator, Reference, target_scale, training_spec
from firstcontact.models._model import WindowModel
from firstcontact.models._spec import Task, Values, Windows

if TYPE_CHECKING:
    from torch import Tensor

    from firstcontact.models._efficientnet import EfficientNet

#: As published.
LEARNING_RATE = 1e-3
HALVE_EVERY = 5
#: Small batches learn more in the few epochs before the rate is spent: at least
#: 16 to an epoch, of at least 8 windows, because they are normalised together.
BATCH = 64
STEPS = 16
SMALLEST = 8


@dataclass(frozen=True)
class Cnn(Estimator):
    """EfficientNetV2 for one dimension: Adam, MSE loss, the rate halved every 5 epochs.

    For classification the loss is the MSE against one-hot targets. Nothing is
    augmented and nothing is searched, so ``groups`` has no use here.
    """

    name: ClassVar[str] = "cnn"
    title: ClassVar[str] = "CNN"
    colour: ClassVar[str] = RED
    model: ClassVar[type[WindowModel]] = CnnModel
    slow: ClassVar[bool] = True
    folds: ClassVar[int] = 3
    modules: ClassVar[tuple[str, ...]] = ("torch", "onnxscript", *CnnModel.modules)
    extra: ClassVar[str] = CnnModel.extra
    quick: ClassVar[Mapping[str, Any]] = MappingProxyType({"epochs": 8})

    epochs: int = 40

    def fit(
        self, X: Windows, y: Values, groups: NDArray[Any] | None = None, seed: int = 0
    ) -> CnnModel:
        """See :meth:`Estimator.fit`. Leaves PyTorch's random state as it was."""
        from firstcontact.models._network_export import export

        spec = training_spec(self.task, self.rate, X, y, groups)
        scale = _scale(X)
        regression = self.task is Task.REGRESSION
        target = target_scale(self.task, y)
        wanted = (
            ((y - target[0]) / target[1])[:, None]
            if regression
            else (y[:, None] == np.array(spec.classes))
        )
        network = _train(compress(X, scale), wanted.astype(np.float32), self.epochs, seed)
        training = np.array([self.epochs, _batch(len(X))], dtype=np.float64)
        return CnnModel(spec, scale, target, training, export(network, spec.samples))

    def reference(self, model: CnnModel, X: Windows, y: Values) -> Reference:
        """Eager PyTorch, with fresh weights, which change no time."""
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


def _scale(X: Windows) -> NDArray[np.float64]:
    amplitude = float(np.median(np.sqrt((X.astype(np.float64) ** 2).mean(axis=(1, 2)))))
    compressed = np.arcsinh(X / amplitude)
    return np.array([amplitude, compressed.mean(), compressed.std()])


def as_input(inputs: NDArray[np.float32]) -> Tensor:
    """Compressed windows (n, samples, channels) as the network takes them, channels last."""
    import torch

    layout = np.ascontiguousarray(inputs.transpose(0, 2, 1))[:, :, None, :]
    return torch.from_numpy(layout).contiguous(memory_format=torch.channels_last)


def _train(
    inputs: NDArray[np.float32], wanted: NDArray[np.float32], epochs: int, seed: int
) -> EfficientNet:
    """A trained network in evaluation mode: same seed and threads, same weights."""
    import torch

    from firstcontact.models._efficientnet import EfficientNet

    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = EfficientNet(inputs.shape[2], wanted.shape[1])
        network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        X, Y = as_input(inputs), torch.from_numpy(wanted)
        optimiser = torch.optim.Adam(network.parameters(), lr=LEARNING_RATE, fused=True)
        schedule = torch.optim.lr_scheduler.StepLR(optimiser, HALVE_EVERY, 0.5)
        loss = torch.nn.MSELoss()
        # The rest of a shuffled epoch is left out: a normalisation needs a whole batch.
        batch = _batch(len(X))
        for _ in range(epochs):
            order = torch.randperm(len(X))
            for start in range(0, len(X) - batch + 1, batch):
                members = order[start : start + batch]
                optimiser.zero_grad()
                loss(network(X[members]), Y[members]).backward()
                optimiser.step()
            schedule.step()
    network.eval()
    return network
