"""Conformance tests of all registered estimators, plug-ins included."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pytest
from numpy.typing import NDArray

from firstcontact.core import InputError
from firstcontact.models import (
    ESTIMATORS,
    Estimator,
    Spec,
    Task,
    WindowModel,
    make_estimator,
    training_spec,
)
from firstcontact.models.registry import model_class, window_estimators
from firstcontact.testing import check_estimator
from firstcontact.testing.synthetic import RATE, toy_windows

pytestmark = pytest.mark.usefixtures("small_searches")
#: Each estimator with each of its tasks. A CNN differs between the two in its last layer alone, and
#: takes longest: its classification is a slow test.
EACH = [
    pytest.param(
        name, task, marks=[pytest.mark.slow] if (name, task) == ("cnn", Task.CLASSIFICATION) else []
    )
    for name, kind in window_estimators().items()
    for task in kind.tasks
]


@pytest.mark.parametrize(("name", "task"), EACH)
def test_it_keeps_the_promises(name: str, task: Task) -> None:
    check_estimator(ESTIMATORS[name], task)
    assert model_class(ESTIMATORS[name].model.kind, of_windows=True) is ESTIMATORS[name].model


@pytest.mark.parametrize(("name", "task"), EACH)
def test_what_is_no_baseline_learns_much_more_than_the_mean(name: str, task: Task) -> None:
    X, y, _ = toy_windows(90, seed=9)

    def error(of: str) -> float:
        model = make_estimator(of, task, RATE, **ESTIMATORS[of].quick).fit(*toy_windows(), seed=3)
        return float(np.sqrt(np.mean((model.predict(X) - y) ** 2)))

    if not ESTIMATORS[name].baseline:
        assert error(name) < 0.7 * error("train_mean")


@pytest.mark.parametrize("name", ["peak", "svm", "log_spectrum"])
def test_classes_may_have_fractional_values(name: str) -> None:
    X, y, groups = toy_windows(90)
    integer, fractional = (
        make_estimator(name, Task.CLASSIFICATION, RATE).fit(X, labels, groups)
        for labels in (y, y - 0.5)
    )
    assert fractional.spec.classes == tuple(np.unique(y) - 0.5)
    np.testing.assert_array_equal(fractional.predict(X), integer.predict(X) - 0.5)


def test_a_task_that_it_does_not_learn_is_refused() -> None:
    for name, kind in window_estimators().items():
        for task in set(Task) - set(kind.tasks):
            with pytest.raises(InputError, match=f"{name} .* {task}"):
                make_estimator(name, task, RATE)


class Echo(WindowModel):
    """Model that predicts the peak of the window. The check must detect faults in subclasses."""

    kind = "echo"

    def __init__(self, spec: Spec, add: float = 0.0) -> None:
        self.spec, self.add = spec, add

    @property
    def notes(self) -> Mapping[str, Any]:
        return {}

    def outputs(self, X: NDArray[np.float32]) -> NDArray[Any]:
        # Toy windows are as loud as they are hard.
        return X.max(axis=(1, 2))[:, None] * 58 + self.add * len(X)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        return {}

    @classmethod
    def from_arrays(cls, spec: Spec, arrays: dict[str, NDArray[Any]]) -> Self:
        return cls(spec)


@dataclass(frozen=True)
class Echoes(Estimator):
    name: ClassVar[str] = "echo"
    title: ClassVar[str] = "Echo"
    model: ClassVar[type[WindowModel]] = Echo
    tasks: ClassVar[tuple[Task, ...]] = (Task.REGRESSION,)

    add: float = 0.0

    def fit(
        self,
        X: NDArray[np.float32],
        y: NDArray[np.float64],
        groups: NDArray[Any] | None = None,
        seed: int = 0,
    ) -> Echo:
        return Echo(training_spec(self.task, self.rate, X, y, groups), self.add)


def test_faults_are_detected(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(AssertionError, match="nothing to check"):
        check_estimator(type("Idle", (Echoes,), {"tasks": ()}))
    with pytest.raises(AssertionError, match="must be installed"):
        check_estimator(type("Heavy", (Echoes,), {"modules": ("no_such_module",)}))
    with pytest.raises(AssertionError, match="another window"):
        check_estimator(type("Odd", (Echoes,), {"quick": {"add": 1.0}}))
    monkeypatch.setattr(Echo, "spread", lambda self, X: np.zeros(len(X)))
    with pytest.raises(AssertionError, match="spread"):
        check_estimator(Echoes)
