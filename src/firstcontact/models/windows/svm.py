"""Window model with a support vector machine, which scikit-learn trains and C code computes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, product
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain import Image, build_image
from firstcontact.chain.constants import SvmConstants, WindowConstants
from firstcontact.chain.touch import svm_outputs
from firstcontact.core.display import BLUE
from firstcontact.core.kernel import RbfKernel
from firstcontact.models.estimator import Estimator, library_targets, target_scale, training_spec
from firstcontact.models.splits import inner_folds
from firstcontact.models.values import Task, Values, Windows
from firstcontact.models.windows.window_model import (
    TARGET,
    ArrayCheck,
    ModelFromArrays,
    Spec,
    WindowModel,
)
from firstcontact.signal import SavitzkyGolay, samples_in
from firstcontact.signal.windowing import BASELINE, BASELINE_GUARD, BASELINE_LEAST

#: Weight of the level relative to a sample of the shape, all with unit variance. With 74 samples
#: the level then carries about a tenth of all variance.
LEVEL_WEIGHT = 3.0
#: Smallest and largest sum of squares of a window (V²). Outside them float32 holds too few digits
#: of the power, and the level is NaN.
LEAST_POWER, MOST_POWER = 1e-30, 1e38
#: Numbers of support vectors of the models that :meth:`SvmModel.smaller` yields.
SIZES = (25, 50, 75, 100, 150, 200, 300, 500)


def loudness_level(X: Windows) -> NDArray[np.float64]:
    """Return mean and standard deviation of ln(RMS) over all windows, shape (2,).

    Windows have the shape (n, samples, channels), in V.
    """
    flat = X.reshape(len(X), -1).astype(np.float64)
    loud = 0.5 * np.log((flat**2).mean(axis=1))
    return np.array([loud.mean(), loud.std() or 1.0])


def shape_and_level(X: Windows, level: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return the inputs of the support vector machine, shape (n, samples * channels + 1).

    These are the windows divided by their RMS, and ln(RMS) as the last column, standardised by
    ``level``, the output of :func:`loudness_level`.
    """
    flat = X.reshape(len(X), X.shape[1] * X.shape[2]).astype(np.float32)
    power = np.einsum("ij,ij->i", flat, flat)
    power[~((power > LEAST_POWER) & (power < MOST_POWER))] = np.nan
    rms = np.sqrt(power / flat.shape[1])
    loud = (np.log(rms) - level[0]) * (LEVEL_WEIGHT / level[1])
    return np.column_stack([flat / rms[:, None], loud]).astype(np.float32)


class SvmModel(ModelFromArrays):
    """Window model with a support vector machine (radial basis function), predicting in float32."""

    kind: ClassVar[str] = "svm"
    declared: ClassVar[Mapping[str, ArrayCheck]] = {
        "level": ArrayCheck((2,), positive=1),
        "vectors": ArrayCheck(("vectors", "shape and level")),
        "weights": ArrayCheck(("decisions", "vectors")),
        "bias": ArrayCheck(("decisions",)),
        "target": TARGET,
        "parameters": ArrayCheck((3,), positive=1),
    }

    @property
    def parameters(self) -> NDArray[np.float64]:
        """Hyper-parameters C, gamma and epsilon that the training chose, shape (3,)."""
        return self._arrays["parameters"]

    @classmethod
    def sizes(cls, spec: Spec) -> dict[str, int]:
        k = len(spec.classes)
        decisions = 1 if spec.task is Task.REGRESSION else k * (k - 1) // 2
        return {"shape and level": spec.samples * spec.channels + 1, "decisions": decisions}

    @property
    def notes(self) -> Mapping[str, Any]:
        c, gamma, epsilon = (float(p) for p in self.parameters)
        chosen = {"C": c, "gamma": gamma, "support_vectors": len(self._arrays["vectors"])}
        return chosen | ({"epsilon": epsilon} if self.spec.task is Task.REGRESSION else {})

    def outputs(self, X: Windows) -> NDArray[np.float32]:
        """Return predictions, shape (n, 1), or votes for each class, shape (n, classes)."""
        return svm_outputs(self._image, X, len(self.spec.classes) or 1)

    @cached_property
    def _image(self) -> Image:
        svm = self.chain_constants()
        before = svm.guard + svm.baseline + SavitzkyGolay.lookahead
        constants = WindowConstants(before, [svm.samples], SavitzkyGolay.lookahead, [svm])
        return build_image(self.spec.rate, model=constants)

    def chain_constants(self) -> SvmConstants:
        """Return the constants that the C chain needs to predict, without those of an interval."""
        a, rate = self._arrays, self.spec.rate
        level, deviation = a["level"]
        mean, scale = self.target
        return SvmConstants(
            samples=self.spec.samples * self.spec.channels,
            baseline=samples_in(BASELINE, rate),
            guard=samples_in(BASELINE_GUARD, rate),
            least=max(1, samples_in(BASELINE_LEAST, rate)),
            level=level,
            slope=LEVEL_WEIGHT / deviation,
            gamma=float(self.parameters[1]),
            mean=mean,
            scale=scale,
            vectors=a["vectors"].astype(np.float32),
            weights=a["weights"],
            bias=a["bias"],
            classes=self.spec.classes,
        )

    def smaller(self, X: Windows) -> Iterator[SvmModel]:
        """Yield faster models with fewer support vectors, the smallest first.

        Each is fitted to predict the same as this model for the windows ``X``.
        """
        level, vectors, weights, bias, target, parameters = self._arrays.values()
        inputs = shape_and_level(X, level)
        for chosen, fitted, offset in _reduced_sets(vectors, float(parameters[1]), weights, inputs):
            narrow = fitted.astype(np.float32), (bias + offset).astype(np.float32)
            yield SvmModel(self.spec, level, vectors[chosen], *narrow, target, parameters)


#: Regularisation: share of the kernel's mean square that is added to keep weights small.
_RIDGE = 1e-8


def _reduced_sets(
    vectors: NDArray[Any], gamma: float, weights: NDArray[Any], inputs: NDArray[Any]
) -> Iterator[tuple[NDArray[np.intp], NDArray[np.float64], NDArray[np.float64]]]:
    """Yield subsets of the support vectors, from small to large, with nearly the same outputs.

    The outputs are compared on ``inputs``. Each subset is a tuple: indices of its vectors, their
    new weights, and what to add to the bias.
    """
    wide = vectors.astype(np.float64)
    kernel = RbfKernel(wide, gamma).rows(inputs.astype(np.float64))
    wanted = kernel @ weights.T.astype(np.float64)
    mean = wanted.mean(axis=0)
    left = wanted - mean
    columns = kernel - kernel.mean(axis=0)
    chosen: list[int] = []
    for size in [s for s in SIZES if s < len(wide)]:
        while len(chosen) < size:
            power = np.maximum((columns**2).sum(axis=0), 1e-12)
            gain = ((columns.T @ left) ** 2).sum(axis=1) / power
            gain[chosen] = -1.0
            best = int(gain.argmax())
            chosen.append(best)
            axis = columns[:, best] / np.sqrt(power[best])
            left = left - np.outer(axis, axis @ left)
            columns = columns - np.outer(axis, axis @ columns)
        part = kernel[:, chosen]
        middle = part.mean(axis=0)
        away = part - middle
        gram = away.T @ away + _RIDGE * len(away) * np.eye(size)
        fitted = np.linalg.solve(gram, away.T @ (wanted - mean))
        yield np.array(chosen, np.intp), fitted.T, mean - middle @ fitted


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
    """Estimator that fits a support vector machine to the shape and the loudness of windows."""

    name: ClassVar[str] = "svm"
    title: ClassVar[str] = "SVM"
    colour: ClassVar[str] = BLUE
    model: ClassVar[type[WindowModel]] = SvmModel
    modules: ClassVar[tuple[str, ...]] = ("sklearn",)
    extra: ClassVar[str] = "train"
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
        return _to_svm_model(spec, level, machine, target, np.array(parameters))


def _sample(task: Task, y: Values) -> NDArray[np.intp]:
    """Return ascending indices of the windows to fit to: all, or ``MOST_WINDOWS`` random ones.

    In a classification, at least one window of each class is included.
    """
    if len(y) <= MOST_WINDOWS:
        return np.arange(len(y))
    order = np.random.default_rng(0).permutation(len(y))
    chosen = order[:MOST_WINDOWS]
    if task is Task.CLASSIFICATION:
        chosen = np.union1d(chosen, order[np.unique(y[order], return_index=True)[1]])
    return np.sort(chosen)


def svm_machine(task: Task, parameters: tuple[float, float, float]) -> Any:
    """Return an untrained SVC or SVR of scikit-learn. ``parameters`` are C, gamma and epsilon."""
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
    """Choose C, gamma and epsilon by cross-validation over three folds, and return them.

    Folds hold out whole ``groups`` (sessions). At most ``most`` random windows are used.
    """
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
    least = min(losses.values())
    return next(each for each in candidates if losses[each] <= TOLERANCE * least)


def _squared_distances(inputs: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return the squared distance between each pair of rows of ``inputs``, shape (n, n)."""
    x = inputs.astype(np.float64)
    squares = np.einsum("ij,ij->i", x, x)
    distances: NDArray[np.float64] = squares[:, None] + squares - 2.0 * (x @ x.T)
    return np.maximum(distances, 0.0)


def _loss(
    task: Task,
    parameters: tuple[float, float, float],
    kernel: NDArray[np.float64],
    y: Values,
    held_out_kernel: NDArray[np.float64],
    truth: Values,
) -> float:
    """Return the error rate or RMSE on held-out windows, for ``parameters`` C, gamma, epsilon.

    ``kernel`` and ``y`` are for training, ``held_out_kernel`` and ``truth`` for the held-out
    windows.
    """
    machine = svm_machine(task, parameters).set_params(kernel="precomputed", tol=SEARCH_ACCURACY)
    predicted = machine.fit(kernel, y).predict(held_out_kernel)
    if task is Task.CLASSIFICATION:
        return float(np.mean(predicted != truth))
    return float(np.sqrt(np.mean((predicted - truth) ** 2)))


def _to_svm_model(
    spec: Spec,
    level: NDArray[np.float64],
    machine: Any,
    target: NDArray[np.float64],
    parameters: NDArray[np.float64],
) -> SvmModel:
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
    """Return the support vectors' weights for each pair of classes, shape (pairs, vectors).

    ``dual`` holds them in libsvm's format, shape (classes - 1, vectors), and ``counts`` the number
    of support vectors of each class.
    """
    end = np.cumsum(counts)
    start = end - counts
    pairs = list(combinations(range(len(counts)), 2))
    rows = np.zeros((len(pairs), dual.shape[1]))
    for row, (i, j) in zip(rows, pairs, strict=True):
        row[start[i] : end[i]] = dual[j - 1, start[i] : end[i]]
        row[start[j] : end[j]] = dual[i, start[j] : end[j]]
    return rows
