"""Trained RBF-SVM as plain arrays, evaluated by NumPy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError, RbfKernel

#: Gamma times the number of features. It is below the usual 1, so that windows louder than all
#: training data still lie within the kernel's reach.
WIDTH = 0.3
#: Largest number of rows whose kernel is in memory at once.
ROWS = 4096


@dataclass(frozen=True, slots=True, eq=False)
class RbfMachine:
    """Decision function ``sum_i w_i exp(-gamma |x - s_i|^2) + b`` of scaled features."""

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
        """Return a machine that is trained on features, shape (windows, features)."""
        from sklearn.svm import SVC

        mean, scale = x.mean(axis=0), x.std(axis=0)
        scale = np.where(scale > 0.0, scale, 1.0)
        gamma = WIDTH / x.shape[1]
        machine = SVC(C=cost, gamma=gamma, class_weight="balanced", cache_size=500)
        machine.fit((x - mean) / scale, positive)
        return cls(
            mean,
            scale,
            machine.support_vectors_,
            machine.dual_coef_[0],
            float(machine.intercept_[0]),
            gamma,
        )

    def decide(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the decision values of windows, shape (windows,). Positive means a contact."""
        with np.errstate(all="ignore"):
            out = self._decide(x)
        if not np.isfinite(out).all():
            raise InputError(
                "the detector's output is not a finite number: train the detector again"
            )
        return out

    def _decide(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        out = np.empty(len(x))
        for start in range(0, len(x), ROWS):
            scaled = (x[start : start + ROWS] - self.mean) / self.scale
            out[start : start + ROWS] = self._kernel.rows(scaled) @ self.weights + self.intercept
        return out

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        """Return all numbers as named arrays."""
        return {n: np.asarray(getattr(self, n), dtype=np.float64) for n in _names(type(self))}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Restore a machine from :meth:`to_arrays`."""
        names = _names(cls)
        missing = [name for name in names if name not in arrays]
        if missing:
            raise InputError(
                f"the detector's array {missing[0]!r} is missing: train the detector again"
            )
        a = {name: np.array(arrays[name], dtype=np.float64) for name in names}
        vectors, features = a["support"].shape if a["support"].ndim == 2 else (-1, -1)
        shapes: dict[str, tuple[int, ...]] = {
            "mean": (features,),
            "scale": (features,),
            "support": (vectors, features),
            "weights": (vectors,),
            "intercept": (),
            "gamma": (),
        }
        for name, shape in shapes.items():
            if a[name].shape != shape or not np.isfinite(a[name]).all():
                raise InputError(
                    f"the detector's array {name!r} has a shape that does not fit the other "
                    "arrays, or holds a number that is not finite: train the detector again"
                )
        if a["scale"].min(initial=1.0) <= 0 or a["gamma"] <= 0:
            raise InputError(
                "the detector's array 'scale' or 'gamma' is not above 0: train the detector again"
            )
        return cls(
            a["mean"],
            a["scale"],
            a["support"],
            a["weights"],
            float(a["intercept"]),
            float(a["gamma"]),
        )


def _names(kind: type[RbfMachine]) -> list[str]:
    """Return the names of the stored fields, without derived fields."""
    return [f.name for f in fields(kind) if f.init]
