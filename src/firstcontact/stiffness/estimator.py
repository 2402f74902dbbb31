"""What an estimator learns and what it leaves behind: protocols and small types."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, ClassVar, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError

Arrays = dict[str, NDArray[Any]]
Windows = NDArray[np.float32]
Values = NDArray[np.float64]


class Task(StrEnum):
    """What is asked of an estimator."""

    REGRESSION = "regression"
    CLASSIFICATION = "classification"


@dataclass(frozen=True, slots=True)
class Spec:
    """What a model takes and what it answers.

    Parameters
    ----------
    task
        Regression answers any real number, classification one of ``classes``.
    rate
        Sampling rate of the windows, Hz.
    samples, channels
        Shape of one window.
    classes
        Values of the classes in ascending order; empty for regression.
    """

    task: Task
    rate: float
    samples: int
    channels: int = 1
    classes: tuple[float, ...] = ()

    @property
    def duration(self) -> float:
        """Length of the window, s."""
        return self.samples / self.rate

    def require_rate(self, rate: float) -> None:
        """Refuse windows of another sampling rate.

        Raises
        ------
        InputError
            If ``rate`` (Hz) differs by more than one per cent.
        """
        if not abs(rate - self.rate) <= 0.01 * self.rate:
            raise InputError(
                f"the model takes windows at {self.rate:g} Hz but these have {rate:g} Hz: "
                f"import the recordings with --rate {self.rate:g}, or train a model on them"
            )

    def check_one(self, window: NDArray[Any]) -> None:
        """Refuse a window that the model cannot answer for.

        Raises
        ------
        InputError
            Another shape than (samples, channels), a non-finite value, or a
            constant channel (an unplugged sensor).
        """
        if window.shape != (self.samples, self.channels):
            raise InputError(
                f"the model takes windows of {self.samples} samples and {self.channels} "
                f"channel(s), shape ({self.samples}, {self.channels}), not {window.shape}: "
                f"cut {1e3 * self.duration:.3g} ms at {self.rate:g} Hz"
            )
        for channel in window.T:
            # NaN fails both comparisons, an infinity the second one.
            if not 0.0 < np.maximum.reduce(channel) - np.minimum.reduce(channel) < np.inf:
                raise InputError(
                    "the window is constant or has values that are not finite: "
                    "check the sensor's plug and leave this pinch out"
                )

    def check(self, X: NDArray[Any]) -> None:
        """Refuse windows, shape (n, samples, channels), as :meth:`check_one` does.

        Raises
        ------
        InputError
            Names the first window that cannot be used.
        """
        if X.ndim != 3 or X.shape[1:] != (self.samples, self.channels):
            raise InputError(
                f"the model takes windows of shape (n, {self.samples}, {self.channels}), "
                f"not {X.shape}: cut {1e3 * self.duration:.3g} ms at {self.rate:g} Hz"
            )
        bad = np.flatnonzero(~usable(X))
        if len(bad):
            raise InputError(
                f"window {bad[0]} ({len(bad)} in all) is constant or has values that are not "
                "finite: check the sensor's plug and leave these pinches out"
            )


class Model(Protocol):
    """A trained estimator, frozen: arrays and arithmetic, no training library."""

    #: Name of the runtime in model files.
    kind: ClassVar[str]

    @property
    def spec(self) -> Spec:
        """What it takes and answers."""
        ...

    @property
    def notes(self) -> Mapping[str, Any]:
        """What the training chose (hyper-parameters, scaling), JSON-ready, for the card."""
        ...

    def predict(self, X: Windows) -> Values:
        """Answer for windows (n, samples, channels): shape (n,); InputError if refused."""
        ...

    def predict_one(self, window: Windows) -> float:
        """Answer for one window (samples, channels), the quick way of the live pipeline."""
        ...

    def to_arrays(self) -> Arrays:
        """Everything the answer depends on beside the spec."""
        ...

    @classmethod
    def from_arrays(cls, spec: Spec, arrays: Arrays) -> Self:
        """The inverse of :meth:`to_arrays`; InputError if the arrays do not fit together."""
        ...


@runtime_checkable
class Estimator(Protocol):
    """Learns a model from windows. Made for one task and one sampling rate."""

    @property
    def name(self) -> str:
        """Name in the registry, in results and on the command line."""
        ...

    @property
    def task(self) -> Task:
        """What it learns."""
        ...

    @property
    def rate(self) -> float:
        """Sampling rate of the windows, Hz."""
        ...

    def fit(
        self,
        X: Windows,
        y: Values,
        groups: NDArray[Any] | None = None,
        seed: int = 0,
    ) -> Model:
        """Learn.

        Parameters
        ----------
        X
            Windows in V, shape (n, samples, channels).
        y
            Shore A, or another real target, shape (n,). For classification
            its distinct values are the classes.
        groups
            Session of each window, shape (n,): anything chosen inside is
            chosen on sessions that the candidate has not seen.
        seed
            Same seed, same data: same model.

        Raises
        ------
        InputError
            Windows that no model would take, or targets that do not fit them.
        """
        ...


def usable(X: NDArray[Any]) -> NDArray[np.bool_]:
    """Which windows (n, samples, channels) are finite and constant in no channel: shape (n,)."""
    if X.shape[1] == 0:
        return np.zeros(len(X), dtype=np.bool_)
    with np.errstate(invalid="ignore"):
        span = X.max(axis=1) - X.min(axis=1)
    good: NDArray[np.bool_] = ((span > 0) & (span < np.inf)).all(axis=1)
    return good


def training_spec(
    task: Task, rate: float, X: Windows, y: Values, groups: NDArray[Any] | None
) -> Spec:
    """Check what an estimator is to learn from.

    Returns
    -------
    Spec
        Of the model to be.

    Raises
    ------
    InputError
        Shapes that do not fit, unusable windows, missing targets, or fewer
        than two classes.
    """
    if X.ndim != 3 or len(X) < 2:
        raise InputError(
            f"training needs at least two windows of shape (samples, channels), got {X.shape}: "
            "give it more pinches"
        )
    if y.shape != (len(X),) or (groups is not None and groups.shape != (len(X),)):
        raise InputError(f"{len(X)} windows need as many targets and sessions, got {y.shape}")
    if not np.isfinite(y).all():
        raise InputError("some pinches have no target: leave those without a Shore A out")
    classes = tuple(float(c) for c in np.unique(y)) if task is Task.CLASSIFICATION else ()
    if len(classes) == 1:
        raise InputError("classification needs two classes or more: add pinches of another object")
    spec = Spec(task, float(rate), X.shape[1], X.shape[2], classes)
    spec.check(X)
    return spec
