"""Support vector machines with a radial basis function kernel, trained by scikit-learn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations, product
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import BLUE
from firstcontact.models._estimator import (
    Estimator,
    Reference,
    library_targets,
    target_scale,
    training_spec,
)
from firstcontact.models._spec import Spec, Task, Values, Windows
from firstcontact.models._splits import inner_folds
from firstcontact.models._svm_model import SvmModel, loudness_level, shape_and_level
from firstcontact.models._window_model import WindowModel

#: Default number of windows for the search.
SEARCH_WINDOWS = 800
#: Largest number of windows for the final model. The time of a fit grows with the square of it.
MOST_WINDOWS = 5_000
#: Candidates of the search. gamma is a multiple of 1 / inputs (each input has unit variance),
#: epsilon is in standard deviations of the target.
C_GRID = (1.0, 10.0, 100.0)
GAMMA_GRID = (0.1, 0.3, 1.0, 3.0)
EPSILON_GRID = (0.3, 0.15, 0.05)
#: Loss, relative to the lowest, up to which a candidate counts as best. The first such candidate is
#: taken: wide tubes and small C come first, because they need fewer support vectors.
TOLERANCE = 1.02
#: Stopping criterion of the solver in the search. Ten times the usual one ranks candidates equally.
SEARCH_ACCURACY = 1e-2


@dataclass(frozen=True)
class Svm(Estimator):
    """Estimator: SVC (one against one) or SVR on the shape and the level of a window.

    Parameters
    ----------
    task, rate
        See :class:`Estimator`.
    search_windows
        Largest number of windows for the search of hyper-parameters. The final model is fitted to
        all windows, or to a random sample of :data:`MOST_WINDOWS` of them.
    """

    name: ClassVar[str] = "svm"
    title: ClassVar[str] = "SVM"
    colour: ClassVar[str] = BLUE
    model: ClassVar[type[WindowModel]] = SvmModel
    quick: ClassVar[Mapping[str, Any]] = MappingProxyType({"search_windows": 400})

    search_windows: int = SEARCH_WINDOWS

    def fit(
        self, X: Windows, y: Values, groups: NDArray[Any] | None = None, seed: int = 0
    ) -> SvmModel:
        """Fit with hyper-parameters from :func:`search`; see :meth:`Estimator.fit`."""
        spec = training_spec(self.task, self.rate, X, y, groups)
        chosen = _sample(self.task, y)
        X, y = X[chosen], y[chosen]
        groups = None if groups is None else groups[chosen]
        level = loudness_level(X)
        inputs = shape_and_level(X, level)
        target = target_scale(self.task, y)
        scaled = (y - target[0]) / target[1]
        parameters = search(self.task, inputs, scaled, groups, seed, self.search_windows)
        machine = svm_machine(self.task, parameters).fit(inputs, library_targets(self.task, scaled))
        return _model(spec, level, machine, target, np.array(parameters))

    def reference(self, model: SvmModel, X: Windows, y: Values) -> Reference:
        """Return scikit-learn's machine, fitted again with the same parameters."""
        arrays = model.to_arrays()
        mean, deviation = arrays["target"]
        chosen = _sample(self.task, y)
        X, y = X[chosen], y[chosen]
        inputs = shape_and_level(X, arrays["level"])
        c, gamma, epsilon = (float(p) for p in arrays["parameters"])
        targets = library_targets(self.task, (y - mean) / deviation)
        machine = svm_machine(self.task, (c, gamma, epsilon)).fit(inputs, targets)
        return Reference("scikit-learn predict", machine.predict, list(inputs[:, None, :]))


def _sample(task: Task, y: Values) -> NDArray[np.intp]:
    """Return the indices of the windows that the model is fitted to, ascending."""
    if len(y) <= MOST_WINDOWS:
        return np.arange(len(y))
    order = np.random.default_rng(0).permutation(len(y))
    chosen = order[:MOST_WINDOWS]
    if task is Task.CLASSIFICATION:
        chosen = np.union1d(chosen, order[np.unique(y[order], return_index=True)[1]])
    return np.sort(chosen)


def svm_machine(task: Task, parameters: tuple[float, float, float]) -> Any:
    """Return an untrained SVC or SVR with these C, gamma and epsilon."""
    from sklearn.svm import SVC, SVR

    c, gamma, epsilon = parameters
    if task is Task.CLASSIFICATION:
        return SVC(C=c, gamma=gamma)
    return SVR(C=c, gamma=gamma, epsilon=epsilon)


def search(
    task: Task,
    inputs: NDArray[np.float32],
    y: Values,
    groups: NDArray[Any] | None,
    seed: int,
    most: int = SEARCH_WINDOWS,
) -> tuple[float, float, float]:
    """Choose C, gamma and epsilon on three grouped folds of at most ``most`` windows."""
    from sklearn import config_context

    rng = np.random.default_rng(seed)
    chosen = np.sort(rng.permutation(len(y))[:most])
    inputs, y = inputs[chosen], y[chosen]
    folds = [
        (train, validation)
        for train, validation in inner_folds(y, None if groups is None else groups[chosen], seed)
        if len(np.unique(y[train])) > 1
    ]
    y = library_targets(task, y)
    gammas = [multiple / inputs.shape[1] for multiple in GAMMA_GRID]
    # The widest tube is first: see TOLERANCE.
    epsilons = EPSILON_GRID if task is Task.REGRESSION else (0.0,)
    if not folds:
        return C_GRID[0], gammas[0], epsilons[0]
    distances = _squared_distances(inputs)
    losses = {}
    with config_context(assume_finite=True, skip_parameter_validation=True):  # many short fits
        for gamma in gammas:
            kernel = np.exp(-gamma * distances)
            sides = [
                (kernel[np.ix_(train, train)], y[train], kernel[np.ix_(ask, train)], y[ask])
                for train, ask in folds
            ]
            for epsilon, c in product(epsilons, C_GRID):
                parameters = c, gamma, epsilon
                losses[parameters] = np.mean([_loss(task, parameters, *side) for side in sides])
    candidates = [(c, gamma, epsilon) for epsilon, c, gamma in product(epsilons, C_GRID, gammas)]
    return candidates[_first_close(np.array([losses[each] for each in candidates]))]


def _first_close(losses: NDArray[np.float64]) -> int:
    """Return the index of the first candidate whose loss is close to the best."""
    return int(np.argmax(losses <= TOLERANCE * losses.min()))


def _squared_distances(inputs: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return the squared distance of each pair of inputs, shape (n, n)."""
    x = inputs.astype(np.float64)
    squares = np.einsum("ij,ij->i", x, x)
    distances: NDArray[np.float64] = squares[:, None] + squares - 2.0 * (x @ x.T)
    return np.maximum(distances, 0.0)


def _loss(
    task: Task,
    parameters: tuple[float, float, float],
    kernel: NDArray[np.float64],
    y: Values,
    asked_kernel: NDArray[np.float64],
    truth: Values,
) -> float:
    """Return the error rate or RMSE of a candidate on one fold."""
    machine = svm_machine(task, parameters).set_params(kernel="precomputed", tol=SEARCH_ACCURACY)
    predicted = machine.fit(kernel, y).predict(asked_kernel)
    if task is Task.CLASSIFICATION:
        return float(np.mean(predicted != truth))
    return float(np.sqrt(np.mean((predicted - truth) ** 2)))


def _model(
    spec: Spec,
    level: NDArray[np.float64],
    machine: Any,
    target: NDArray[np.float64],
    parameters: NDArray[np.float64],
) -> SvmModel:
    """Return a model of this package from scikit-learn's machine."""
    weights, bias = machine.dual_coef_, machine.intercept_
    if spec.task is Task.CLASSIFICATION:
        if len(spec.classes) == 2:  # only here a positive value means the second class
            weights, bias = -weights, -bias
        weights = _one_against_one(weights, machine.n_support_)
    return SvmModel(
        spec,
        level,
        machine.support_vectors_.astype(np.float32),
        weights.astype(np.float32),
        bias.astype(np.float32),
        target,
        parameters,
    )


def _one_against_one(dual: NDArray[np.float64], counts: NDArray[Any]) -> NDArray[np.float64]:
    """Return a row of weights for each pair of classes, from libsvm's packed coefficients."""
    end = np.cumsum(counts)
    start = end - counts
    pairs = list(combinations(range(len(counts)), 2))
    rows = np.zeros((len(pairs), dual.shape[1]))
    for row, (i, j) in zip(rows, pairs, strict=True):
        row[start[i] : end[i]] = dual[j - 1, start[i] : end[i]]
        row[start[j] : end[j]] = dual[i, start[j] : end[j]]
    return rows
