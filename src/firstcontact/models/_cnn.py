"""Training of the convolutional network with PyTorch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from math import cos, pi
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import RED
from firstcontact.models._cnn_model import CnnModel, compress
from firstcontact.models._estimator import Estimator, Reference, target_scale, training_spec
from firstcontact.models._spec import Task, Values, Windows
from firstcontact.models._window_model import WindowModel

if TYPE_CHECKING:
    from torch import Tensor

    from firstcontact.models._efficientnet import EfficientNet

#: Largest rate of a one-cycle schedule, and the share of its steps in which the rate rises.
#: Smith and Topin: Super-Convergence, 2018 (arXiv:1708.07120).
LEARNING_RATE = 4e-3
RISE = 0.25
#: Schedule of the paper: rate of Adam, epochs between halvings, and epochs in all.
PUBLISHED_RATE, HALVE_EVERY, PUBLISHED_EPOCHS = 1e-3, 5, 40
#: Smallest number of batches in an epoch, and smallest batch. Small batches train better in few
#: epochs, and the windows of a batch are normalised together.
BATCH = 64
STEPS = 16
SMALLEST = 8


@dataclass(frozen=True)
class Cnn(Estimator):
    """EfficientNetV2 for one dimension: Adam with a one-cycle schedule, MSE loss.

    For classification the loss is the MSE against one-hot targets. Without augmentation and
    hyper-parameter search, ``groups`` is not used.

    Parameters
    ----------
    task, rate
        See :class:`Estimator`.
    epochs
        Passes over the windows.
    published
        True to use the paper's schedule: 40 epochs, with the learning rate halved every 5. It
        scores the same and takes three times as long.
    """

    name: ClassVar[str] = "cnn"
    title: ClassVar[str] = "CNN"
    colour: ClassVar[str] = RED
    model: ClassVar[type[WindowModel]] = CnnModel
    slow: ClassVar[bool] = True
    folds: ClassVar[int] = 3
    modules: ClassVar[tuple[str, ...]] = ("torch", *CnnModel.modules)
    extra: ClassVar[str] = CnnModel.extra
    quick: ClassVar[Mapping[str, Any]] = MappingProxyType({"epochs": 8})

    epochs: int = 12
    published: bool = False

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
        epochs = PUBLISHED_EPOCHS if self.published else self.epochs
        network = _train(
            compress(X, scale), wanted.astype(np.float32), epochs, self.published, seed
        )
        training = np.array([epochs, _batch(len(X))], dtype=np.float64)
        onnx = np.frombuffer(export(network, spec.samples), dtype=np.uint8)
        return CnnModel(spec, scale, target, training, onnx)

    def reference(self, model: CnnModel, X: Windows, y: Values) -> Reference:
        """Return eager PyTorch with random weights, which do not affect the time."""
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
    inputs: NDArray[np.float32],
    wanted: NDArray[np.float32],
    epochs: int,
    published: bool,
    seed: int,
) -> EfficientNet:
    """Return a trained network in evaluation mode: same seed and threads, same weights."""
    import torch

    from firstcontact.models._efficientnet import EfficientNet

    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = EfficientNet(inputs.shape[2], wanted.shape[1])
        network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        X, Y = as_input(inputs), torch.from_numpy(wanted)
        rate = PUBLISHED_RATE if published else LEARNING_RATE
        optimiser = torch.optim.Adam(network.parameters(), lr=rate, fused=True)
        loss = torch.nn.MSELoss()
        # The rest of a shuffled epoch is left out: a normalisation needs a whole batch.
        batch = _batch(len(X))
        steps = len(X) // batch
        halving = HALVE_EVERY * steps
        schedule = torch.optim.lr_scheduler.LambdaLR(
            optimiser,
            (lambda step: 0.5 ** (step // halving))
            if published
            else partial(_one_cycle, steps=epochs * steps),
        )
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
