"""Base classes of estimators, and checks that all estimators share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ArgumentError
from firstcontact.core.display import SKY
from firstcontact.models.values import Task, Values, Windows
from firstcontact.models.windows.window_model import Spec, WindowModel

if TYPE_CHECKING:
    from firstcontact.models.anytime import AnytimeModel
    from firstcontact.models.touches import Touches

#: Windows, targets and sessions (or None) that a model is fitted to.
TrainingSet = tuple[Windows, Values, NDArray[Any] | None]


@dataclass(frozen=True)
class EstimatorInfo:
    """Base class of all estimators: class attributes such as name, title and supported tasks."""

    #: Name on the command line, in files and in results.
    name: ClassVar[str]
    #: Title for readers, and colour in figures.
    title: ClassVar[str]
    colour: ClassVar[str] = SKY
    #: Class of the models that it fits.
    model: ClassVar[Any]
    #: Supported tasks.
    tasks: ClassVar[tuple[Task, ...]] = tuple(Task)
    #: True for a baseline, which is only scored for comparison.
    baseline: ClassVar[bool] = False
    #: True if training is slow. Studies then run it last.
    slow: ClassVar[bool] = False
    #: True if its models are meant to transfer to other sensors.
    moves: ClassVar[bool] = False
    #: Number of folds for the interval of a final model.
    folds: ClassVar[int] = 5
    #: Largest number of sets in one call of :meth:`Estimator.fit_several`, which trains faster.
    together: ClassVar[int] = 1
    #: Modules that training needs beyond the base install, and the extra that contains them.
    modules: ClassVar[tuple[str, ...]] = ()
    extra: ClassVar[str] = ""
    #: Settings for fast training, used in small studies and repeated trainings.
    quick: ClassVar[Mapping[str, Any]] = MappingProxyType({})

    task: Task
    rate: float


@dataclass(frozen=True)
class Estimator(EstimatorInfo, ABC):
    """Base class of estimators that fit a model to windows (signals cut after contacts).

    To add an estimator, write a subclass with the class attributes of :class:`EstimatorInfo` in a
    new file, and add a line to :mod:`firstcontact.models.registry`.
    """

    @abstractmethod
    def fit(
        self, X: Windows, y: Values, groups: NDArray[Any] | None = None, seed: int = 0
    ) -> WindowModel:
        """Fit a model to windows.

        Parameters
        ----------
        X
            Windows in V, shape (n, samples, channels).
        y
            Target, on the scale of its quantity, shape (n,). For classification its distinct values
            are the classes.
        groups
            Session of each window, (n,), or None. Choose hyper-parameters on held-out sessions.
        seed
            Random seed. The same seed and data give the same model.
        """

    def fit_several(self, sets: Sequence[TrainingSet], seed: int = 0) -> Sequence[WindowModel]:
        """Fit one model to each training set, a tuple (X, y, groups) of arguments of :meth:`fit`.

        The base class fits one after the other. A subclass may fit several at once, which is
        faster.
        """
        return [self.fit(*each, seed=seed) for each in sets]


@dataclass(frozen=True)
class AnytimeEstimator(EstimatorInfo, ABC):
    """Base class of estimators that make an any-time model from contacts with their whole signals.

    To add an estimator, write a subclass with the class attributes of :class:`EstimatorInfo` in a
    new file, and add a line to :mod:`firstcontact.models.registry`. ``name`` must be the ``kind``
    of its models, a subclass of :class:`AnytimeModel`. :func:`firstcontact.testing.check_anytime`
    tests the estimator.
    """

    tasks: ClassVar[tuple[Task, ...]] = (Task.REGRESSION,)

    @abstractmethod
    def fit(
        self,
        touches: Touches,
        shore_a: Values,
        sessions: NDArray[np.str_] | None = None,
        seed: int = 0,
    ) -> tuple[AnytimeModel, Sequence[str]]:
        """Make a model from contacts with objects of known Shore A.

        Parameters
        ----------
        touches
            Contacts with their signals.
        shore_a
            Shore A of each contact's object, shape (n,).
        sessions
            Session of each contact, shape (n,), or None. Hold out whole sessions.
        seed
            Random seed. The same seed and data give the same model.

        Returns
        -------
        model : AnytimeModel
            Model with its record of the training.
        notes : sequence of str
            Sentences for the user, such as scores on held-out contacts.
        """


def target_scale(task: Task, y: Values) -> NDArray[np.float64]:
    """Return mean and standard deviation of training targets, shape (2,); (0, 1) for classes."""
    if task is Task.CLASSIFICATION:
        return np.array([0.0, 1.0])
    return np.array([y.mean(), y.std() or 1.0])


def library_targets(task: Task, y: Values) -> NDArray[Any]:
    """Return targets as scikit-learn accepts them: real numbers, or class numbers from 0."""
    return np.unique(y, return_inverse=True)[1] if task is Task.CLASSIFICATION else y


def training_spec(
    task: Task, rate: float, X: Windows, y: Values, groups: NDArray[Any] | None
) -> Spec:
    """Return the specification of a model for these windows, with the sampling ``rate`` in Hz.

    Raise InputError if the windows, targets or groups cannot be used for training.
    """
    if X.ndim != 3 or len(X) < 2:
        raise ArgumentError(
            f"training needs windows of shape (2 or more, samples, channels), got {X.shape}: "
            "give it more pinches"
        )
    if y.shape != (len(X),) or (groups is not None and groups.shape != (len(X),)):
        sessions = "none" if groups is None else groups.shape
        raise ArgumentError(
            f"{len(X)} windows need {len(X)} targets and sessions, got targets of shape {y.shape} "
            f"and sessions of shape {sessions}: give one of each per window"
        )
    if not np.isfinite(y).all():
        raise ArgumentError("some pinches have no target: leave out the pinches without a label")
    classes = tuple(float(c) for c in np.unique(y)) if task is Task.CLASSIFICATION else ()
    if len(classes) == 1:
        raise ArgumentError("classification needs 2 or more classes: add pinches of another object")
    spec = Spec(task, float(rate), X.shape[1], X.shape[2], classes)
    spec.check(X)
    return spec
