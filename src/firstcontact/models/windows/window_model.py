"""Base class of window models, with the checks of their inputs and outputs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from types import EllipsisType
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain.constants import SvmConstants
from firstcontact.core import ModelError
from firstcontact.core.physics import is_same_rate
from firstcontact.models.values import Arrays, Task, Values, Windows


@dataclass(frozen=True, slots=True)
class Spec:
    """Specification of a window model: its task, and the rate and shape of its windows.

    Parameters
    ----------
    task
        Task. Regression predicts any real number, classification one of ``classes``.
    rate
        Sampling rate of the windows, Hz.
    samples, channels
        Number of samples and number of channels of one window.
    classes
        Values of the classes in ascending order; empty for regression.

    Examples
    --------
    >>> spec = Spec(Task.REGRESSION, rate=4936.0, samples=74)
    >>> round(1e3 * spec.duration)
    15
    """

    task: Task
    rate: float
    samples: int
    channels: int = 1
    classes: tuple[float, ...] = ()

    @property
    def duration(self) -> float:
        """Length of a window, s."""
        return self.samples / self.rate

    def require_rate(self, rate: float) -> None:
        """Raise InputError if this rate (Hz) differs from that of the model by more than 1 %."""
        if not is_same_rate(rate, self.rate):
            raise ModelError(
                f"the model needs windows at {self.rate:g} Hz, but these have {rate:g} Hz: train a "
                f"model for this rate with `firstcontact train --rate {rate:g}`"
            )

    def check(self, X: NDArray[Any]) -> None:
        """Raise InputError if windows ``X`` do not have the model's shape, or are unusable."""
        if X.ndim != 3 or X.shape[1:] != (self.samples, self.channels):
            raise ModelError(
                f"the model needs windows of shape (n, {self.samples}, {self.channels}), "
                f"not {X.shape}: cut {1e3 * self.duration:.3g} ms at {self.rate:g} Hz"
            )
        bad = np.flatnonzero(~usable(X))
        if len(bad):
            raise ModelError(
                f"window {bad[0]} (and {len(bad) - 1} more) is constant or has values that are not "
                "finite: check the sensor's plug and leave these pinches out"
            )


def usable(X: NDArray[Any]) -> NDArray[np.bool_]:
    """Return True for each window that is finite and not constant, shape (n,).

    Windows ``X`` have the shape (n, samples, channels).
    """
    if X.shape[1] == 0:
        return np.zeros(len(X), dtype=np.bool_)
    with np.errstate(invalid="ignore", over="ignore"):
        span = X.max(axis=1) - X.min(axis=1)
    good: NDArray[np.bool_] = ((span > 0) & (span < np.inf)).all(axis=1)
    return good


#: Limit on predictions. No target is as large, and squares of errors stay finite.
LARGEST = 1e9


class WindowModel(ABC):
    """Base class of trained models that predict from a window: a signal of fixed length.

    A model predicts without the library that trained it. A subclass implements :meth:`outputs`. The
    base class checks the windows before it calls that method, and refuses outputs that are not
    finite.
    """

    #: Name of this kind of model in model files.
    kind: ClassVar[str]
    #: Modules that the model needs beyond the base install, and the pip extra that installs them.
    modules: ClassVar[tuple[str, ...]] = ()
    extra: ClassVar[str] = ""
    #: Specification of the model's windows and predictions.
    spec: Spec
    #: Mean and scale of a regression: a prediction is ``output * scale + mean``.
    target: tuple[float, float] = (0.0, 1.0)

    @property
    def name(self) -> str:
        """Name of the estimator that made the model, in results and messages."""
        return self.kind

    @property
    @abstractmethod
    def notes(self) -> Mapping[str, Any]:
        """Hyper-parameters and scaling that training chose, as JSON for ``model.json``."""

    @abstractmethod
    def outputs(self, X: Windows) -> NDArray[Any]:
        """Return one number per window, or one per window and class, shape (n, outputs).

        ``X`` holds usable windows, shape (n, samples, channels). Outputs of a regression are turned
        into predictions by ``target``, those of a classification by :meth:`choose`.
        """

    def spread(self, X: Windows) -> Values | None:
        """Return the predicted standard deviation of each prediction, shape (n,).

        The base class returns None, for models without standard deviations. A standard deviation
        must be above 0, in the unit of the prediction. It scales the half width of the conformal
        interval. ``X`` holds windows that were checked already, shape (n, samples, channels).
        """
        return None

    def chain_constants(self) -> SvmConstants | None:
        """Return the constants that the C chain needs to predict; None for a model in Python."""
        return None

    def choose(self, outputs: NDArray[Any]) -> NDArray[np.intp]:
        """Return the index into ``spec.classes`` of each predicted class, shape (n,).

        The base class chooses the class with the largest output.
        """
        return np.asarray(outputs.argmax(axis=1))

    @abstractmethod
    def to_arrays(self) -> Arrays:
        """Return all arrays that predictions depend on, by name."""

    @classmethod
    @abstractmethod
    def from_arrays(cls, spec: Spec, arrays: Arrays) -> Self:
        """Restore a model from its arrays. Raise InputError if they do not fit together."""

    def predict(self, X: Windows) -> Values:
        """Return one prediction per window, on the scale of the training targets, shape (n,).

        ``X`` has the shape (n, samples, channels). Raise InputError if a window cannot be used, or
        a prediction is not finite.
        """
        self.spec.check(X)
        with np.errstate(all="ignore"):  # predictions that overflow are refused below
            outputs = self.outputs(X)
            sure = np.isfinite(outputs).all(axis=1)
            if self.spec.task is Task.REGRESSION:
                mean, scale = self.target
                answers = outputs[:, 0].astype(np.float64) * scale + mean
                sure &= np.abs(answers) < LARGEST
            else:
                answers = np.array(self.spec.classes)[self.choose(outputs)]
        bad = np.flatnonzero(~sure)
        if len(bad):
            raise ModelError(
                f"the prediction for window {bad[0]} is not a finite number below 1e9: leave this "
                "pinch out, or train the model again"
            )
        return answers


@dataclass(frozen=True, slots=True)
class ArrayCheck:
    """Shape and sign that an array of a model must have, checked when the model is loaded."""

    #: Length of each axis: a number, or a name from :meth:`ModelFromArrays.sizes`. A name that is
    #: not there stands for any length that is the same in all arrays.
    shape: tuple[int | str, ...]
    #: Index of values that must be above 0; ``...`` means all values.
    positive: int | slice | EllipsisType | None = None

    def is_met(self, array: NDArray[Any], sizes: dict[str, int]) -> bool:
        """Return True if an array has finite floating-point numbers of the declared shape.

        The length of a name in the shape is taken from ``sizes``. If ``sizes`` lacks the name, the
        length is added there.
        """
        if array.ndim != len(self.shape) or not np.issubdtype(array.dtype, np.floating):
            return False
        for size, wanted in zip(array.shape, self.shape, strict=True):
            if size != (wanted if isinstance(wanted, int) else sizes.setdefault(wanted, size)):
                return False
        if not np.isfinite(array).all():
            return False
        return self.positive is None or bool((array[self.positive] > 0).all())


class ModelFromArrays(WindowModel):
    """Window model that is stored as arrays, whose names and shapes :attr:`declared` lists.

    The constructor takes the spec, then the arrays in the order of :attr:`declared`. It raises
    InputError if the shape or a value of an array is invalid. The optional array ``target`` holds
    the mean and the scale of the training targets of a regression.
    """

    #: Required shape and sign of each array, by the name of the array in model files.
    declared: ClassVar[Mapping[str, ArrayCheck]]

    def __init__(self, spec: Spec, *arrays: NDArray[Any]) -> None:
        self.spec = spec
        self._arrays = dict(zip(self.declared, arrays, strict=True))
        sizes = self.sizes(spec)
        for name, check in self.declared.items():
            array = self._arrays[name]
            if not check.is_met(array, sizes):
                shape = ", ".join(str(size) for size in check.shape)
                raise ModelError(
                    f"the array '{name}' with the shape {array.shape} does not fit a model of kind "
                    f"{self.kind!r}, which needs the shape ({shape}), finite values, and factors "
                    "above 0: train again"
                )
        if "target" in self._arrays:
            mean, scale = self._arrays["target"]
            self.target = float(mean), float(scale)

    @classmethod
    def sizes(cls, spec: Spec) -> dict[str, int]:
        """Return the lengths of array axes by the names that :attr:`declared` uses for them.

        ``inputs`` is the number of values in a window; ``outputs`` is the number of classes, or 1.
        """
        return {"inputs": spec.samples * spec.channels, "outputs": len(spec.classes) or 1}

    def to_arrays(self) -> Arrays:
        return dict(self._arrays)

    @classmethod
    def from_arrays(cls, spec: Spec, arrays: Arrays) -> Self:
        return cls(spec, *(arrays[name] for name in cls.declared))


#: Declared mean and scale of the targets.
TARGET = ArrayCheck((2,), positive=1)
