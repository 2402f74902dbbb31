"""Gaussian-process regression, trained by scikit-learn. It predicts a standard deviation as well.

C. E. Rasmussen and C. K. I. Williams: Gaussian Processes for Machine Learning, 2006, chapter 2. If
there are many windows, only a subset is used (section 8.3.3), because memory and time of a
prediction grow with the square of the number of windows.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.display import PURPLE
from firstcontact.core.kernel import RbfKernel
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
from firstcontact.models.values import Values
from firstcontact.models.windows.svm import loudness_level, shape_and_level
from firstcontact.models.windows.window_model import TARGET, ArrayCheck

#: Largest number of windows that a model keeps, and that the search for the kernel uses.
MAX_WINDOWS = 800
SEARCHED = 300


class GaussianProcessModel(ModelFromArrays):
    """Gaussian process with a squared exponential kernel and noise.

    Parameters
    ----------
    spec
        Specification of the model's inputs and outputs.
    level
        Level argument of :func:`firstcontact.models.shape_and_level`.
    inputs
        Shape and level of each training window that the model stores, shape (m, inputs).
    weights
        Weights of the predicted mean, shape (m,).
    inverse
        Inverse of the Cholesky factor of the stored windows' covariance, shape (m, m).
    kernel
        Variance of the signal, length scale, and variance of the noise.
    target
        Mean and standard deviation of the targets.

    Raises
    ------
    InputError
        If the arrays do not fit together.
    """

    kind: ClassVar[str] = "gaussian_process"
    declared: ClassVar[Mapping[str, ArrayCheck]] = {
        "level": ArrayCheck((2,), positive=1),
        "inputs": ArrayCheck(("windows", "shape and level")),
        "weights": ArrayCheck(("windows",)),
        "inverse": ArrayCheck(("windows", "windows")),
        "kernel": ArrayCheck((3,), positive=...),
        "target": TARGET,
    }

    def __init__(self, spec: Spec, *arrays: NDArray[Any]) -> None:
        super().__init__(spec, *arrays)
        _, inputs, _, _, kernel, _ = self._arrays.values()
        self._signal, self._length, self._noise = (float(k) for k in kernel)
        self._shape = RbfKernel(inputs.astype(np.float64) / self._length, 0.5)

    @classmethod
    def sizes(cls, spec: Spec) -> dict[str, int]:
        """Return array lengths that ``spec`` determines; see :meth:`ModelFromArrays.sizes`."""
        return {"shape and level": spec.samples * spec.channels + 1}

    @property
    def notes(self) -> Mapping[str, Any]:
        """Return the chosen kernel, and the number of stored windows."""
        return {
            "signal": self._signal,
            "length": self._length,
            "noise": self._noise,
            "windows": len(self._shape),
        }

    def _covariance(self, X: Windows) -> NDArray[np.float64]:
        """Return the covariance of windows with the stored windows, shape (n, m)."""
        x = shape_and_level(X, self._arrays["level"]).astype(np.float64) / self._length
        covariance: NDArray[np.float64] = self._signal * self._shape.rows(x)
        return covariance

    def outputs(self, X: Windows) -> Values:
        """Return the predicted mean for each window, shape (n, 1)."""
        mean: Values = self._covariance(X) @ self._arrays["weights"][:, None]
        return mean

    def spread(self, X: Windows) -> Values:
        """Return the predicted standard deviation for each window, noise included."""
        projected = self._covariance(X) @ self._arrays["inverse"].T
        variance = self._signal + self._noise - np.einsum("ij,ij->i", projected, projected)
        spread: Values = np.sqrt(np.maximum(variance, self._noise)) * self.target[1]
        return spread


@dataclass(frozen=True)
class GaussianProcess(Estimator):
    """Gaussian-process regression on the shape and the level (log RMS) of a window.

    Parameters
    ----------
    task, rate
        Task and sampling rate, as for every estimator; regression only.
    max_windows
        Largest number of training windows that the model stores, evenly spaced in the order of
        targets.
    """

    name: ClassVar[str] = "gaussian_process"
    title: ClassVar[str] = "Gaussian process"
    colour: ClassVar[str] = PURPLE
    model: ClassVar[type[WindowModel]] = GaussianProcessModel
    tasks: ClassVar[tuple[Task, ...]] = (Task.REGRESSION,)
    quick: ClassVar[Mapping[str, Any]] = MappingProxyType({"max_windows": 300})

    max_windows: int = MAX_WINDOWS

    def fit(
        self, X: Windows, y: Values, groups: NDArray[Any] | None = None, seed: int = 0
    ) -> GaussianProcessModel:
        """Fit the kernel with the highest marginal likelihood; see :meth:`Estimator.fit`."""
        spec = training_spec(self.task, self.rate, X, y, groups)
        level = loudness_level(X)
        positions = _spaced(y, self.max_windows, seed)
        inputs = shape_and_level(X[positions], level)
        target = target_scale(self.task, y)
        wanted = (y[positions] - target[0]) / target[1]
        few = _spaced(wanted, SEARCHED, seed)
        signal, length, noise = _kernel(inputs[few], wanted[few])
        scaled = inputs.astype(np.float64) / length
        covariance = signal * RbfKernel(scaled, 0.5).rows(scaled) + noise * np.eye(len(positions))
        inverse = np.linalg.inv(np.linalg.cholesky(covariance))
        return GaussianProcessModel(
            spec,
            level,
            inputs,
            inverse.T @ (inverse @ wanted),
            inverse.astype(np.float32),
            np.array([signal, length, noise]),
            target,
        )


def _spaced(y: Values, most: int, seed: int) -> NDArray[np.intp]:
    """Return the ascending positions of up to ``most`` targets, evenly spaced when sorted."""
    shuffled = np.random.default_rng(seed).permutation(len(y))
    ordered = shuffled[np.argsort(y[shuffled], kind="stable")]
    spaced = np.linspace(0, len(y) - 1, min(most, len(y))).round().astype(np.intp)
    return np.sort(ordered[spaced])


def _form(signal: float, length: float, noise: float) -> Any:
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    return ConstantKernel(signal, (1e-2, 1e3)) * RBF(length, (1e-1, 1e3)) + WhiteKernel(
        noise, (1e-3, 1e1)
    )


def _kernel(inputs: NDArray[np.float32], wanted: Values) -> tuple[float, float, float]:
    """Return signal variance, length scale and noise variance of the most likely kernel."""
    import warnings

    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor

    process = GaussianProcessRegressor(_form(1.0, float(np.sqrt(inputs.shape[1])), 0.1))
    with warnings.catch_warnings():
        # Ignore the warning that a parameter is at the end of its range: the best value within the
        # range is wanted.
        warnings.simplefilter("ignore", ConvergenceWarning)
        process.fit(inputs.astype(np.float64), wanted)
    signal, length, noise = np.exp(process.kernel_.theta)
    return float(signal), float(length), float(noise)
