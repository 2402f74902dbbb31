"""Predictions are finite numbers, also when the arithmetic overflows."""

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Self

import numpy as np
import pytest
from numpy.typing import NDArray

from firstcontact.core import InputError
from firstcontact.models import ESTIMATORS, Spec, Task, WindowModel, make_estimator
from firstcontact.models.registry import window_estimators
from firstcontact.testing.synthetic import RATE, toy_windows
from saved import load_arrays, load_window, replace_arrays, save_window


class Constant(WindowModel):
    """Model with a fixed output, to test the code of the base class."""

    kind = "told"

    def __init__(self, task: Task, outputs: list[float]) -> None:
        self.spec = Spec(task, RATE, 74, 1, (10.0, 29.0) if task is Task.CLASSIFICATION else ())
        self._outputs = np.array(outputs)

    @property
    def notes(self) -> Mapping[str, Any]:
        return {}

    def outputs(self, X: NDArray[np.float32]) -> NDArray[np.float64]:
        rows = np.zeros((len(X), len(self._outputs)))
        rows[-1] = self._outputs
        return rows

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        return {}

    @classmethod
    def from_arrays(cls, spec: Spec, arrays: dict[str, NDArray[Any]]) -> Self:
        raise NotImplementedError


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("task", Task)
@pytest.mark.parametrize("place", [0, 1])
def test_outputs_that_are_not_finite_are_no_answer(task: Task, value: float, place: int) -> None:
    outputs = [1.0, 2.0]
    outputs[place] = value
    if task is Task.REGRESSION:
        outputs = [value]
    model, X = Constant(task, outputs), toy_windows(5)[0]
    with pytest.raises(InputError, match=r"window 4 .*not a finite number"):
        model.predict(X)


@pytest.mark.parametrize("value", [1e200, -1e10])
def test_an_answer_whose_square_overflows_is_none(value: float) -> None:
    model, X = Constant(Task.REGRESSION, [value]), toy_windows(3)[0]
    with pytest.raises(InputError, match="not a finite number below 1e9"):
        model.predict(X)


def test_finite_outputs_are_answers() -> None:
    X = toy_windows(3)[0]
    assert Constant(Task.REGRESSION, [42.0]).predict(X[:1]) == 42.0
    assert Constant(Task.CLASSIFICATION, [1.0, 2.0]).predict(X).tolist() == [10.0, 10.0, 29.0]


@pytest.mark.parametrize("scale", [1e38, 1e-38])
@pytest.mark.parametrize(
    ("name", "task"),
    [(name, task) for name, kind in window_estimators().items() for task in kind.tasks],
)
def test_windows_at_the_ends_of_float32(name: str, task: Task, scale: float) -> None:
    """The squares overflow or become 0. Such windows get a finite prediction or are refused."""
    X, y, _ = toy_windows(24)
    model = make_estimator(name, task, RATE, **ESTIMATORS[name].quick).fit(X, y)
    window = np.clip(X[0] / np.abs(X[0]).max(), -1, 1) * np.float32(scale)
    with suppress(InputError):
        assert np.isfinite(model.predict(window[None])).all()


@pytest.mark.parametrize("task", Task)
@pytest.mark.parametrize("name", ["svm", "cnn"])
def test_weights_of_a_file_that_overflow(name: str, task: Task, tmp_path: Path) -> None:
    X, y, _ = toy_windows(24)
    estimator = make_estimator(name, task, RATE, **ESTIMATORS[name].quick)
    folder = save_window(estimator.fit(X, y), tmp_path / "m")
    arrays = load_arrays(folder)
    replace_arrays(folder, {**arrays, "weights": np.full_like(arrays["weights"], 3e38)})
    model = load_window(folder)
    with pytest.raises(InputError, match=r"not a finite number|too large"):
        model.predict(X)
