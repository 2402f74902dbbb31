"""Base class of estimators, and the checks that all share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import SKY, InputError
from firstcontact.models._spec import Spec, Task, Values, Windows
from firstcontact.models._window_model import WindowModel


@dataclass(frozen=True)
class Estimator(ABC):
    """Learns a model from windows.

    A new one is a subclass in a file of its own, with these class attributes, and a line
    in :mod:`firstcontact.models._registry`; commands, studies, figures and reports read
    the rest from here.

    Parameters
    ----------
    task
        What it learns.
    rate
        Sampling rate of the windows, Hz.
    """

    #: On the command line, in files and in results.
    name: ClassVar[str]
    #: As people read it, and its colour in figures.
    title: ClassVar[str]
    colour: ClassVar[str] = SKY
    #: What its models are.
    model: ClassVar[type[WindowModel]]
    #: What it can learn.
    tasks: ClassVar[tuple[Task, ...]] = tuple(Task)
    #: Whether it is a floor to stand on rather than something to be used.
    baseline: ClassVar[bool] = False
    #: Whether training takes long: a report is to be readable before.
    slow: ClassVar[bool] = False
    #: Whether it is made to be asked by another sensor than it learned from.
    moves: ClassVar[bool] = False
    #: True if it learns from windows by `fit`; False if from whole contacts, by `fit_contacts`.
    takes_windows: ClassVar[bool] = True
    #: Folds from which the interval of a model to keep is computed.
    folds: ClassVar[int] = 5
    #: Modules that training needs and the base install lacks, and the extra that brings them.
    modules: ClassVar[tuple[str, ...]] = ()
    extra: ClassVar[str] = ""
    #: Fields with which it learns quickly, for small studies and for many trainings.
    quick: ClassVar[Mapping[str, Any]] = MappingProxyType({})

    task: Task
    rate: float

    @abstractmethod
    def fit(
        self,
        X: Windows,
        y: Values,
        groups: NDArray[Any] | None = None,
        seed: int = 0,
    ) -> WindowModel:
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

    def reference(self, model: Any, X: Windows, y: Values) -> Reference | None:
        """Return the training library's own prediction, for timing; by default there is none.

        Parameters
        ----------
        model
            One of its models.
        X, y
            What it was trained on.
        """
        return None


@dataclass(frozen=True, slots=True)
class Reference:
    """Another program that answers the same question about one window.

    Parameters
    ----------
    name
        Of the program.
    call
        ``call(inputs[i])`` does the work.
    inputs
        Ready made, one a window.
    """

    name: str
    call: Callable[[Any], object]
    inputs: Sequence[Any]


def target_scale(task: Task, y: Values) -> NDArray[np.float64]:
    """Mean and standard deviation that targets are learned in; (0, 1) of classes."""
    if task is Task.CLASSIFICATION:
        return np.array([0.0, 1.0])
    return np.array([y.mean(), y.std() or 1.0])


def training_spec(
    task: Task, rate: float, X: Windows, y: Values, groups: NDArray[Any] | None
) -> Spec:
    """Check the training data of an estimator. Return the model's specification.

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
