"""What learns: the protocol of estimators, and what all of them check first."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError
from firstcontact.stiffness.model import Model
from firstcontact.stiffness.spec import Spec, Task, Values, Windows


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
