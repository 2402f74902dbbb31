"""Published contact detector: a support vector machine (RBF-SVM) on windows of 20 ms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact.closing_start import cut_closings
from firstcontact.contact.detector import TrainedDetector, spread_out, stored_array
from firstcontact.contact.training import (
    PHASES,
    TrainingWindows,
    feature_count,
    session_groups,
    training_windows,
    window_features,
)
from firstcontact.core import Dataset, ModelError
from firstcontact.core.display import BLUE
from firstcontact.core.installation import require_modules
from firstcontact.core.kernel import RbfKernel

#: Gamma times the number of features. It is below the usual 1, so that windows louder than all
#: training data still lie within the kernel's reach.
WIDTH = 0.3
#: Largest number of rows whose kernel is in memory at once.
ROWS = 4096


@dataclass(frozen=True, slots=True, eq=False)
class RbfMachine:
    """Trained support vector machine: ``sum_i w_i exp(-gamma |x - s_i|^2) + b`` of features x."""

    mean: NDArray[np.float64]
    scale: NDArray[np.float64]
    support: NDArray[np.float64]
    weights: NDArray[np.float64]
    intercept: float
    gamma: float
    _kernel: RbfKernel = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_kernel", RbfKernel(self.support, self.gamma))

    @classmethod
    def train(cls, x: NDArray[np.float64], positive: NDArray[np.bool_], cost: float) -> Self:
        """Train a machine on features ``x``, shape (windows, features).

        ``positive`` marks the windows with a contact, and ``cost`` is the parameter C of the
        machine.
        """
        require_modules("train", "sklearn")
        from sklearn.svm import SVC

        mean, scale = x.mean(axis=0), x.std(axis=0)
        scale = np.where(scale > 0.0, scale, 1.0)
        gamma = WIDTH / x.shape[1]
        machine = SVC(C=cost, gamma=gamma, class_weight="balanced", cache_size=500)
        machine.fit((x - mean) / scale, positive)
        weights, intercept = machine.dual_coef_[0], float(machine.intercept_[0])
        return cls(mean, scale, machine.support_vectors_, weights, intercept, gamma)

    def decide(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the decision value of each window, shape (windows,). Positive means a contact.

        ``x`` holds features, shape (windows, features).
        """
        out = np.empty(len(x))
        with np.errstate(all="ignore"):
            for start in range(0, len(x), ROWS):
                rows = self._kernel.rows((x[start : start + ROWS] - self.mean) / self.scale)
                out[start : start + ROWS] = rows @ self.weights + self.intercept
        if not np.isfinite(out).all():
            raise ModelError(
                "the detector's output is not a finite number: train the detector again"
            )
        return out

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        names = [field.name for field in fields(self) if field.init]
        return {name: np.asarray(getattr(self, name), dtype=np.float64) for name in names}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Restore a machine from :meth:`to_arrays`. Raise ModelError if the arrays do not fit."""
        support = np.asarray(arrays.get("support"))
        vectors, features = support.shape if support.ndim == 2 else (-1, -1)
        shapes: dict[str, tuple[int, ...]] = {
            "support": (vectors, features),
            "mean": (features,),
            "scale": (features,),
            "weights": (vectors,),
            "intercept": (),
            "gamma": (),
        }
        a = {name: stored_array(arrays, name, shape) for name, shape in shapes.items()}
        if a["scale"].min(initial=1.0) <= 0 or a["gamma"] <= 0:
            raise ModelError(
                "the detector's arrays 'scale' and 'gamma' must be above 0: train a detector again"
            )
        stored = a["mean"], a["scale"], a["support"], a["weights"]
        return cls(*stored, float(a["intercept"]), float(a["gamma"]))


#: Limits on the training data, so that training takes less than a minute: pinches, windows per
#: class at first, hard windows added per class and round, and rounds.
PINCHES = 1500
EACH = 2000
HARD = 500
ROUNDS = 2
#: Soft-margin cost, and number of folds for the threshold.
COST = 100.0
FOLDS = 3


class SvmDetector(TrainedDetector):
    """Contact detector with one RBF-SVM for both fingers. Its inputs are features of a window.

    Training begins with some windows that end at several times after contacts, and some that end
    before contacts. The windows that the SVM classifies worst are then added, and the SVM is
    trained again. The threshold on its decision value is chosen on held-out folds of the training
    pinches, grouped by session. It is the middle of the range in which the most first contacts are
    detected correctly.

    Parameters
    ----------
    seed
        Random seed of the training.
    """

    name: ClassVar[str] = "svm"
    title: ClassVar[str] = "SVM"
    colour: ClassVar[str] = BLUE
    lowest: ClassVar[float] = 1520.0

    def __init__(self, seed: int = 0) -> None:
        super().__init__(seed)
        self._machine: RbfMachine | None = None
        self._threshold = 0.0

    @property
    def trained(self) -> bool:
        return self._machine is not None

    def fit(self, dataset: Dataset, early: float = 0.0) -> Self:
        """Train on pinches with labelled first contacts, from where the hand starts to close."""
        dataset = cut_closings(dataset)
        rate, sizes = self._window_sizes(dataset)
        subset = spread_out(dataset, sizes, early, PINCHES)
        data = training_windows(subset, sizes, early, self.seed)
        usable_pinches = np.unique(data.pinch[data.positive])
        if len(usable_pinches) < 2:
            raise self._too_few(len(usable_pinches))
        groups = np.zeros(len(subset), dtype=np.intp)
        groups[usable_pinches] = session_groups(subset.sessions[usable_pinches], FOLDS)
        held_out = np.empty(len(data.features))
        for fold in range(FOLDS):
            test = (groups % FOLDS == fold)[data.pinch]
            if test.any():
                machine = _train(data.take(~test), self.seed)
                held_out[test] = machine.decide(data.features[test])
        self._threshold = _best_threshold(data, held_out)
        self._machine = _train(data, self.seed)
        self._rate = rate
        return self

    def fires(self, windows: NDArray[np.float64]) -> NDArray[np.bool_]:
        return self.decision(windows) > self._threshold

    def decision(self, windows: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the SVM's decision values, shape (windows, fingers).

        High values mean a contact.
        """
        assert self._machine is not None
        n, fingers, samples = windows.shape
        features = window_features(
            windows.reshape(n * fingers, samples), self.sizes(self._rate).step
        )
        return self._machine.decide(features).reshape(n, fingers)

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        self._require_training("there is nothing to save")
        assert self._machine is not None
        extra = {"threshold": np.asarray(self._threshold), "rate": np.asarray(self._rate)}
        return self._machine.to_arrays() | extra

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        detector = cls()
        detector._machine = RbfMachine.from_arrays(arrays)
        detector._threshold = float(stored_array(arrays, "threshold", ()))
        detector._rate = float(stored_array(arrays, "rate", ()))
        features = feature_count(cls.sizes(detector._rate).step)
        if len(detector._machine.mean) != features:
            raise ModelError(
                f"the detector has {len(detector._machine.mean)} features, but a window at "
                f"{detector._rate:g} Hz has {features}: train the detector again"
            )
        return detector


def _train(data: TrainingWindows, seed: int) -> RbfMachine:
    """Train on random windows, add the windows that are classified worst, and train again."""
    rng = np.random.default_rng(seed)
    sign = np.where(data.positive, 1.0, -1.0)
    classes = [np.flatnonzero(data.positive), np.flatnonzero(~data.positive)]
    chosen = np.concatenate([rng.permutation(c)[:EACH] for c in classes])
    machine = _fit(data, chosen)
    for _ in range(ROUNDS):
        margin = sign * machine.decide(data.features)
        margin[chosen] = np.inf
        hardest = [c[np.argsort(margin[c])[:HARD]] for c in classes]
        chosen = np.union1d(chosen, np.concatenate(hardest))
        machine = _fit(data, chosen)
    return machine


def _fit(data: TrainingWindows, chosen: NDArray[np.intp]) -> RbfMachine:
    return RbfMachine.train(data.features[chosen], data.positive[chosen], COST)


def _best_threshold(data: TrainingWindows, decision: NDArray[np.float64]) -> float:
    """Return the threshold on decision values that detects the most first contacts correctly.

    ``decision`` holds the decision value of each window. A higher one counts as a contact.
    """
    is_quiet = data.first & ~data.positive
    is_loud = data.first & data.positive
    pinches = np.unique(data.pinch[is_loud])
    quiet = np.full(data.pinch.max() + 1, -np.inf)
    by_phase = np.full((data.pinch.max() + 1, PHASES), -np.inf)
    np.maximum.at(quiet, data.pinch[is_quiet], decision[is_quiet])
    np.maximum.at(by_phase, (data.pinch[is_loud], data.phase[is_loud]), decision[is_loud])
    quiet, loud = quiet[pinches], by_phase[pinches].min(axis=1)
    candidates = np.unique(np.concatenate([quiet, loud]))
    candidates = candidates[np.isfinite(candidates)]
    right = ((quiet[:, None] <= candidates) & (candidates < loud[:, None])).sum(axis=0)
    first = int(np.argmax(right))
    # The count stays the same up to the next candidate that changes it.
    next_change = first + int(np.argmax(np.append(right[first:] < right[first], True)))
    return float((candidates[first] + candidates[min(next_change, len(candidates) - 1)]) / 2.0)
