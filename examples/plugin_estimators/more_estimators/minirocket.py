"""MiniRocket with ridge regression. Features say how often a kernel's output exceeds a threshold.

A. Dempster, D. F. Schmidt, G. I. Webb: MiniRocket: A Very Fast (Almost) Deterministic Transform for
Time Series Classification, KDD 2021. This version uses NumPy alone. The packages that contain
MiniRocket (aeon, sktime) also install Numba, pandas and many megabytes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError
from firstcontact.core.display import ORANGE
from firstcontact.models import (
    Estimator,
    ModelFromArrays,
    Spec,
    Task,
    WindowModel,
    Windows,
    training_spec,
)
from firstcontact.models.estimator import target_scale
from firstcontact.models.splits import inner_folds
from firstcontact.models.values import Values
from firstcontact.models.windows.window_model import TARGET, ArrayCheck

#: Number of taps of a kernel, and weight of its three positive taps. The other six weights are -1.
TAPS, HIGH = 9, 2.0
#: Approximate number of features: a few biases for each of the 84 kernels and each dilation.
FEATURES = 1008
#: Strengths of the ridge penalty that are compared, on held-out sessions.
RIDGES = tuple(10.0**k for k in range(6))
#: Windows that are transformed at once.
_BATCH = 128
_TRIPLES = np.array(list(combinations(range(TAPS), 3)))
#: The 84 kernels, shape (84, 9).
KERNELS = np.full((len(_TRIPLES), TAPS), -1.0, dtype=np.float32)
np.put_along_axis(KERNELS, _TRIPLES, np.float32(HIGH), axis=1)


def dilations(samples: int) -> NDArray[np.int64]:
    """Return the ascending distances between a kernel's taps, for windows of ``samples``."""
    most = max(1.0, (samples - 1) / (TAPS - 1))
    return np.unique(np.logspace(0, np.log2(most), 5, base=2.0).astype(np.int64))


def convolve(X: Values, dilation: int) -> Values:
    """Return windows (n, samples), zero-padded, convolved with each kernel: (n, 84, samples)."""
    reach = dilation * (TAPS // 2)
    padded = np.pad(X, ((0, 0), (reach, reach)))
    starts = dilation * np.arange(TAPS)[:, None] + np.arange(X.shape[1])
    return np.asarray(KERNELS @ padded[:, starts])


def normalised(X: Windows) -> Values:
    """Return the channels of each window end to end, divided by its RMS: (n, samples * channels).

    The result has double precision. In single precision some sums are so close to a bias that the
    order of their terms decides which is larger, and this order differs between machines.
    """
    flat = X.transpose(0, 2, 1).reshape(len(X), -1).astype(np.float64)
    rms = np.sqrt(np.einsum("ij,ij->i", flat, flat) / flat.shape[1])
    return np.asarray(flat / rms[:, None])


class MiniRocketModel(ModelFromArrays):
    """Linear model on the log RMS of a window and on how often kernels' outputs exceed thresholds.

    Parameters
    ----------
    spec
        Specification of the model's inputs and outputs.
    steps
        Dilations of the kernels, shape (d,).
    biases
        Thresholds on the kernels' outputs, k for each kernel and dilation, shape (d, 84, k).
    mean, scale
        Mean and scale of each feature, shape (84 d k + 1,).
    weights
        One row per output; its last value is the offset. Shape (outputs, features + 1).
    target
        Mean and standard deviation of the targets of a regression, else (0, 1).
    ridge
        Chosen strength of the ridge penalty, shape (1,).

    Raises
    ------
    InputError
        If the arrays do not fit together.
    """

    kind: ClassVar[str] = "minirocket"
    declared: ClassVar[Mapping[str, ArrayCheck]] = {
        "dilations": ArrayCheck(("dilations",)),
        "biases": ArrayCheck(("dilations", len(KERNELS), "quantiles")),
        "mean": ArrayCheck(("features",)),
        "scale": ArrayCheck(("features",), positive=...),
        "weights": ArrayCheck(("outputs", "features and offset")),
        "target": TARGET,
        "ridge": ArrayCheck((1,)),
    }

    def __init__(self, spec: Spec, *arrays: NDArray[Any]) -> None:
        super().__init__(spec, *arrays)
        dilations, biases, mean, scale, weights, *_ = self._arrays.values()
        if (len(mean), weights.shape[1]) != (biases.size + 1, biases.size + 2):
            raise InputError("the arrays of MiniRocket do not fit together: train again")
        longest = spec.samples * spec.channels
        if not ((dilations >= 1) & (dilations <= longest) & (dilations % 1 == 0)).all():
            raise InputError("a dilation of MiniRocket does not fit its windows: train again")
        self._weights = (weights[:, :-1] / scale).astype(np.float32)
        self._offsets = weights[:, -1] - self._weights @ mean

    @property
    def notes(self) -> Mapping[str, Any]:
        """Return the number of features, and the chosen strength of the ridge penalty."""
        return {"features": self._weights.shape[1], "ridge": float(self._arrays["ridge"][0])}

    def outputs(self, X: Windows) -> NDArray[np.float32]:
        """Return the output of the linear model, shape (n, outputs)."""
        steps, biases = self._arrays["dilations"], self._arrays["biases"]
        parts = [
            features(X[i : i + _BATCH], steps, biases) @ self._weights.T
            for i in range(0, len(X), _BATCH)
        ]
        none = np.zeros((0, len(self._weights)), dtype=np.float32)
        out: NDArray[np.float32] = np.concatenate([none, *parts]) + self._offsets
        return out


def features(
    X: Windows, distances: NDArray[Any], biases: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Return the share of each kernel's output above each bias, and the log RMS: (n, features)."""
    waves = normalised(X)
    shares = [
        (convolve(waves, int(step))[:, :, None, :] > bias[:, :, None]).mean(axis=3)
        for step, bias in zip(distances, biases, strict=True)
    ]
    flat = X.reshape(len(X), -1).astype(np.float64)
    log_rms = 0.5 * np.log((flat**2).mean(axis=1))
    every = [*(s.reshape(len(X), -1) for s in shares), log_rms]
    return np.column_stack(every).astype(np.float32)


@dataclass(frozen=True)
class MiniRocket(Estimator):
    """Ridge regression on MiniRocket's features of a window, and on the window's log RMS.

    For classification it predicts one target per class: 1 for the class, -1 for the other classes.
    Biases are quantiles of the kernels' output on training windows.
    """

    name: ClassVar[str] = "minirocket"
    title: ClassVar[str] = "MiniRocket"
    colour: ClassVar[str] = ORANGE
    model: ClassVar[type[WindowModel]] = MiniRocketModel

    def fit(
        self, X: Windows, y: Values, groups: NDArray[Any] | None = None, seed: int = 0
    ) -> MiniRocketModel:
        """Fit with a ridge penalty chosen on held-out sessions; see :meth:`Estimator.fit`."""
        spec = training_spec(self.task, self.rate, X, y, groups)
        steps = dilations(X.shape[1] * X.shape[2])
        biases = _biases(normalised(X), steps, seed)
        inputs = np.concatenate(
            [features(X[i : i + _BATCH], steps, biases) for i in range(0, len(X), _BATCH)]
        )
        mean, scale = inputs.mean(axis=0), inputs.std(axis=0)
        scale = np.where(scale > 1e-6, scale, 1.0).astype(np.float32)
        regression = self.task is Task.REGRESSION
        target = target_scale(self.task, y)
        wanted = (
            ((y - target[0]) / target[1])[:, None]
            if regression
            else np.where(y[:, None] == np.array(spec.classes), 1.0, -1.0)
        )
        weights, ridge = _ridge((inputs - mean) / scale, wanted, y, groups, seed)
        return MiniRocketModel(
            spec, steps.astype(np.float64), biases, mean, scale, weights, target, np.array([ridge])
        )


def _biases(waves: Values, steps: NDArray[np.int64], seed: int) -> NDArray[np.float32]:
    """Return quantiles of each kernel's output on random windows, shape (d, 84, k)."""
    k = max(1, FEATURES // (len(KERNELS) * len(steps)))
    # Low-discrepancy quantiles by the golden ratio, as published.
    golden = (np.arange(1, len(steps) * len(KERNELS) * k + 1) * (np.sqrt(5) - 1) / 2) % 1.0
    levels = golden.reshape(len(steps), len(KERNELS), k)
    chosen = np.random.default_rng(seed).permutation(len(waves))[:_BATCH]
    biases = np.empty(levels.shape, dtype=np.float32)
    for i, step in enumerate(steps):
        ordered = np.sort(convolve(waves[chosen], int(step)).transpose(1, 0, 2).reshape(84, -1))
        places = (levels[i] * (ordered.shape[1] - 1)).round().astype(np.intp)
        biases[i] = np.take_along_axis(ordered, places, axis=1)
    return biases


def _ridge(
    inputs: NDArray[np.float32],
    wanted: NDArray[np.float64],
    y: Values,
    groups: NDArray[Any] | None,
    seed: int,
) -> tuple[NDArray[np.float32], float]:
    """Return weights with offsets, (outputs, features + 1), and the penalty of least error."""
    x = inputs.astype(np.float64)
    errors = np.zeros(len(RIDGES))
    for train, validation in inner_folds(y, groups, seed):
        for place, weights in enumerate(_ridges(x[train], wanted[train], RIDGES)):
            predicted = x[validation] @ weights[:, :-1].T + weights[:, -1]
            errors[place] += np.mean((predicted - wanted[validation]) ** 2)
    strength = RIDGES[int(np.argmin(errors))]
    (weights,) = _ridges(x, wanted, [strength])
    return weights.astype(np.float32), strength


def _ridges(
    x: NDArray[np.float64], wanted: NDArray[np.float64], strengths: Sequence[float]
) -> Iterator[NDArray[np.float64]]:
    """Yield weights and offset for each penalty. The products of the features are computed once.

    If there are fewer windows than features, it solves the dual problem: that is smaller and gives
    the same weights.
    """
    from scipy.linalg import solve

    centre, middle = x.mean(axis=0), wanted.mean(axis=0)
    x, along = x - centre, wanted - middle
    is_dual = len(x) < x.shape[1]
    products = x @ x.T if is_dual else x.T @ x
    along = along if is_dual else x.T @ along
    for strength in strengths:
        ridge = products.copy()
        ridge.flat[:: len(ridge) + 1] += strength
        solution = solve(ridge, along, assume_a="pos", overwrite_a=True)
        weights = (x.T @ solution if is_dual else solution).T
        yield np.column_stack([weights, middle - weights @ centre])
