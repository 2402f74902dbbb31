"""Linear model on the log spectrum of a window, which does not depend on the sensor's gain.

It transfers well to other rigs. Contacts with harder objects are shorter (Hertz), which shifts
energy to higher frequencies and to the start of the window. The model has about twenty weights per
class. In training, the windows of each session have the same total weight.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ModelError
from firstcontact.core.display import SKY
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

#: Number of bands of the coarse spectrum, their lowest edge, Hz, and the padded length of windows.
BANDS = 16
LOWEST = 100.0
PADDED = 256
#: Added to a line's share of the energy before the logarithm, relative to an even share. Lines 30
#: dB below an even share are noise, whose level depends on the sensor.
FLOOR = 1e-3
#: Quantiles of the energy. The times at which they are reached describe the window.
QUANTILES = (0.10, 0.25, 0.50, 0.75, 0.90)
_TINY = 1e-300

Features = Callable[[Values, float], Values]


def features(kind: str, X: Windows, rate: float) -> Values:
    """Return the features of windows, shape (n, features).

    ``kind`` is a key of ``KINDS``. Windows ``X`` have the shape (n, samples, channels), ``rate`` is
    in Hz.
    """
    waves = X.astype(np.float64)
    # Then the squares of any finite floats stay within range.
    waves /= np.maximum(np.abs(waves).max(axis=(1, 2), keepdims=True), _TINY)
    return np.concatenate([KINDS[kind](waves[:, :, c], rate) for c in range(X.shape[2])], axis=1)


def log_bands(waves: Values, rate: float) -> Values:
    """Return the log spectrum of each wave in bands, without its mean, shape (n, BANDS)."""
    padded = max(PADDED, 1 << (waves.shape[1] - 1).bit_length())
    return _level_free(_power(waves, padded) @ in_bands(padded, rate))


def log_bins(waves: Values, rate: float) -> Values:
    """Return the log spectrum of each wave, without its mean, shape (n, samples // 2 + 1)."""
    return _level_free(_power(waves, waves.shape[1]))


def course(waves: Values, rate: float) -> Values:
    """Return features of each wave over time, shape (n, 8).

    They are five times at which shares of the energy are reached, the rate of sign changes, the
    roughness, and the time of the peak. Times are shares of the window.
    """
    n = waves.shape[1]
    energy = np.cumsum(waves**2, axis=1)
    total = np.maximum(energy[:, -1:], _TINY)
    come = np.stack([(energy < q * total).sum(axis=1) / n for q in QUANTILES], axis=1)
    signs = np.sign(waves)
    turns = (signs[:, 1:] != signs[:, :-1]).mean(axis=1)
    steps = (np.diff(waves, axis=1) ** 2).sum(axis=1)
    rough = np.log(np.maximum(steps, _TINY) / total[:, 0])
    peak = np.abs(waves).argmax(axis=1) / n
    return np.column_stack([come, turns, rough, peak])


def _power(waves: Values, length: int) -> Values:
    n = waves.shape[1]
    fade = np.hanning(2 * n + 1)[n : 2 * n]  # the contact is at the start
    power: Values = np.abs(np.fft.rfft(waves * fade, length, axis=1)) ** 2
    return power


def _level_free(power: Values) -> Values:
    share = power / np.maximum(power.sum(axis=1, keepdims=True), _TINY)
    logs = np.log(share + FLOOR / power.shape[1])
    free: Values = logs - logs.mean(axis=1, keepdims=True)
    return free


@cache
def in_bands(padded: int, rate: float) -> NDArray[np.float64]:
    """Return weights that average the frequencies of a spectrum in each band, (frequencies, BANDS).

    ``padded`` is the length of the transformed signal, samples; ``rate`` is in Hz. Bands have equal
    frequency ratios.
    """
    lines = np.fft.rfftfreq(padded, 1.0 / rate)
    edges = np.geomspace(min(LOWEST, rate / 8), rate / 2, BANDS + 1)
    inside = (lines[:, None] >= edges[:-1]) & (lines[:, None] <= edges[1:])
    nearest = np.abs(lines[:, None] - np.sqrt(edges[:-1] * edges[1:])).argmin(axis=0)
    inside[nearest, np.arange(BANDS)] |= ~inside.any(axis=0)
    weights: NDArray[np.float64] = inside / inside.sum(axis=0)
    return weights


#: Kinds of features, the one with the fewest inputs first.
KINDS: Mapping[str, Features] = {
    "bands": log_bands,
    "bands and course": lambda waves, rate: np.concatenate(
        [log_bands(waves, rate), course(waves, rate)], axis=1
    ),
    "lines": log_bins,
}


#: Inverse strengths of the regularisation, strongest first. Each is tried with each kind of input,
#: on held-out groups.
C_GRID = (1e-3, 1e-2, 1e-1, 1.0)
SEARCH_WINDOWS = 1000
#: Stopping criterion of the solver in the final fit, and a coarser one for the search, which ranks
#: candidates equally.
ACCURACY, SEARCH_ACCURACY = 1e-4, 1e-2
#: Number of groups up to which each is left out in turn. More groups are divided into this number
#: of folds.
MOST_GROUPS, FOLDS = 12, 5
#: Smallest probability that is counted, so that a single window does not decide a search.
LEAST = 1e-3


class LogSpectrumModel(ModelFromArrays):
    """Linear model on standardised features of a window's log spectrum."""

    kind: ClassVar[str] = "log_spectrum"
    declared: ClassVar[Mapping[str, ArrayCheck]] = {
        "kind": ArrayCheck((1,)),
        "scale": ArrayCheck((2, "features"), positive=1),
        "weights": ArrayCheck(("features", "outputs")),
        "bias": ArrayCheck(("outputs",)),
        "target": TARGET,
        "parameters": ArrayCheck((1,)),
    }

    def __init__(self, spec: Spec, *arrays: NDArray[Any]) -> None:
        super().__init__(spec, *arrays)
        [kind], scale, *_ = self._arrays.values()
        self._features = dict(enumerate(KINDS)).get(kind, "")
        blank = np.ones((1, spec.samples, spec.channels), np.float32)
        inputs = features(self._features, blank, spec.rate).shape[1] if self._features else 0
        if inputs != scale.shape[1]:
            raise ModelError(
                "the shapes or values of the log-spectrum model's arrays do not fit together: "
                "train again"
            )

    @property
    def notes(self) -> Mapping[str, Any]:
        return {"inputs": self._features, "C": float(self._arrays["parameters"][0])}

    def outputs(self, X: Windows) -> Values:
        """Return scores (n, classes), or predictions in standard deviations of targets, (n, 1)."""
        mean, deviation = self._arrays["scale"]
        inputs = (features(self._features, X, self.spec.rate) - mean) / deviation
        out: Values = inputs @ self._arrays["weights"] + self._arrays["bias"]
        return out


@dataclass(frozen=True)
class LogSpectrum(Estimator):
    """Estimator that fits a logistic or ridge regression to the log spectrum of windows."""

    name: ClassVar[str] = "log_spectrum"
    title: ClassVar[str] = "Log spectrum"
    colour: ClassVar[str] = SKY
    model: ClassVar[type[WindowModel]] = LogSpectrumModel
    moves: ClassVar[bool] = True
    modules: ClassVar[tuple[str, ...]] = ("sklearn",)
    extra: ClassVar[str] = "train"
    quick: ClassVar[Mapping[str, Any]] = MappingProxyType({"search_windows": 300})

    search_windows: int = SEARCH_WINDOWS

    def fit(
        self, X: Windows, y: Values, groups: NDArray[Any] | None = None, seed: int = 0
    ) -> LogSpectrumModel:
        """Fit with features and strength C chosen on held-out groups; see :meth:`Estimator.fit`."""
        spec = training_spec(self.task, self.rate, X, y, groups)
        target = target_scale(self.task, y)
        wanted = (y - target[0]) / target[1]
        kind, c = self._search(X, wanted, groups, seed)
        fitted = _fit(self.task, features(kind, X, self.rate), wanted, groups, c)
        number = np.array([float(list(KINDS).index(kind))])
        return LogSpectrumModel(spec, number, *fitted, target, np.array([c]))

    def _search(
        self, X: Windows, y: Values, groups: NDArray[Any] | None, seed: int
    ) -> tuple[str, float]:
        """Return the kind of features and the parameter C with the least loss on held-out windows.

        C is the inverse strength of the regularisation.
        """
        rng = np.random.default_rng(seed)
        chosen = np.sort(rng.permutation(len(y))[: self.search_windows])
        y, groups = y[chosen], None if groups is None else groups[chosen]
        folds = [
            (train, validation)
            for train, validation in _folds(y, groups, seed)
            if self.task is Task.REGRESSION or set(y[validation]) <= set(y[train]) != {y[train[0]]}
        ]
        best = (np.inf, next(iter(KINDS)), C_GRID[0])
        for kind in KINDS if folds else ():
            inputs = features(kind, X[chosen], self.rate)
            for c in C_GRID:
                loss = self._loss(inputs, y, groups, folds, c)
                best = min(best, (loss, kind, c), key=lambda candidate: candidate[0])
        return best[1], best[2]

    def _loss(
        self,
        inputs: Values,
        y: Values,
        groups: NDArray[Any] | None,
        folds: list[tuple[NDArray[np.intp], NDArray[np.intp]]],
        c: float,
    ) -> float:
        """Return the weighted mean loss on the held-out folds, for the parameter ``c``.

        The loss is the negative log probability of the true class, or the squared error in a
        regression.
        """
        losses, held_out = [], []
        for train, validation in folds:
            learned = None if groups is None else groups[train]
            scale, weights, bias = _fit(
                self.task, inputs[train], y[train], learned, c, SEARCH_ACCURACY
            )
            outputs = (inputs[validation] - scale[0]) / scale[1] @ weights + bias
            if self.task is Task.REGRESSION:
                losses.append((outputs[:, 0] - y[validation]) ** 2)
            else:
                column = np.searchsorted(np.unique(y[train]), y[validation])
                outputs -= outputs.max(axis=1, keepdims=True)
                shares = np.exp(outputs) / np.exp(outputs).sum(axis=1, keepdims=True)
                right = shares[np.arange(len(validation)), column]
                losses.append(-np.log(np.maximum(right, LEAST)))
            held_out.append(validation)
        positions = np.concatenate(held_out)
        share = _even_weights(self.task, y, groups)[positions]
        return float(np.average(np.concatenate(losses), weights=share))


def _folds(
    y: Values, groups: NDArray[Any] | None, seed: int
) -> Iterable[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Return folds as pairs of index arrays: windows for training, and held-out windows.

    Each fold holds out one group, which is a session. With more than ``MOST_GROUPS`` groups, one
    group or none, there are ``FOLDS`` folds.
    """
    names = np.unique(groups) if groups is not None else np.array([])
    if not 2 <= len(names) <= MOST_GROUPS:
        return inner_folds(y, groups, seed, FOLDS)
    return [(np.flatnonzero(groups != name), np.flatnonzero(groups == name)) for name in names]


def _even_weights(task: Task, y: Values, groups: NDArray[Any] | None) -> Values:
    """Return a weight per sample, so that all classes and all groups have the same total weight.

    The mean weight is 1.
    """
    weights = np.ones(len(y))
    classes = np.unique(y, return_inverse=True)[1]
    if groups is not None:
        names, number = np.unique(groups, return_inverse=True)
        if task is Task.CLASSIFICATION:
            number = classes * len(names) + number
        weights /= np.bincount(number)[number]
    if task is Task.CLASSIFICATION:
        weights /= np.bincount(classes, weights)[classes]
    even: Values = weights * (len(y) / weights.sum())
    return even


def _fit(
    task: Task,
    inputs: Values,
    y: Values,
    groups: NDArray[Any] | None,
    c: float,
    accuracy: float = ACCURACY,
) -> tuple[Values, Values, Values]:
    """Fit a linear model to inputs, shape (n, features). Classes and groups count equally.

    ``c`` is the inverse strength of the regularisation. Return the scale (mean and standard
    deviation of each feature), weights (features, outputs), and bias (outputs,).
    """
    import warnings

    from sklearn.exceptions import ConvergenceWarning
    from sklearn.linear_model import LogisticRegression, Ridge

    share = _even_weights(task, y, groups)
    mean = np.average(inputs, axis=0, weights=share)
    deviation = np.sqrt(np.average((inputs - mean) ** 2, axis=0, weights=share))
    # A feature that hardly varies is not scaled up.
    deviation = np.where(deviation > 1e-9, deviation, 1.0)
    scaled = (inputs - mean) / deviation
    scale = np.stack([mean, deviation])
    if task is Task.REGRESSION:
        line = Ridge(alpha=1.0 / c).fit(scaled, y, sample_weight=share)
        return scale, line.coef_.reshape(-1, 1), np.atleast_1d(line.intercept_)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # close enough for a candidate
        machine = LogisticRegression(C=c, max_iter=3000, tol=accuracy)
        fitted = machine.fit(scaled, library_targets(task, y), sample_weight=share)
    weights, bias = fitted.coef_.T, fitted.intercept_
    if len(fitted.classes_) == 2:  # a single output, for the second class
        weights, bias = np.hstack([np.zeros_like(weights), weights]), np.append(0.0, bias)
    return scale, weights, bias
