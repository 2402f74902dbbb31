"""Regressors and classifiers of scikit-learn as estimators: training, saving and refusals."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
import pytest
from sklearn.decomposition import PCA
from sklearn.ensemble import HistGradientBoostingRegressor, RandomForestRegressor
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, WhiteKernel
from sklearn.linear_model import LogisticRegression, Ridge
from sklearn.model_selection import GridSearchCV
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import FunctionTransformer, StandardScaler

import firstcontact as fc
from firstcontact.core import Dataset, InputError
from firstcontact.models import Task
from firstcontact.models.registry import find_estimator
from firstcontact.models.windows.regressor import RegressorModel, from_skops, to_skops
from firstcontact.recording import load_dataset
from firstcontact.testing import check_estimator
from firstcontact.testing.synthetic import RATE, toy_windows
from saved import load_window, save_window
from trainings import recordings

pytestmark = pytest.mark.usefixtures("small_searches")

PIPELINE = make_pipeline(StandardScaler(), Ridge(10))
RIDGE = "sklearn.linear_model:Ridge"


class Mean:
    """Regressor of a type that skops does not trust, so that it cannot be loaded."""

    def fit(self, X: Any, y: Any) -> Mean:
        self.mean = float(y.mean())
        return self

    def predict(self, X: Any) -> Any:
        return np.full(len(X), self.mean)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return load_dataset(recordings(tmp_path_factory.mktemp("pinches") / "p"))


CLASSIFIER = make_pipeline(StandardScaler(), LogisticRegression())


@pytest.mark.parametrize(
    ("kind", "task"), [(PIPELINE, Task.REGRESSION), (CLASSIFIER, Task.CLASSIFICATION)]
)
def test_it_keeps_the_promises_of_estimators(kind: Any, task: Task) -> None:
    assert find_estimator(kind).tasks == (task,)
    check_estimator(find_estimator(kind))


def test_a_classifier_names_a_fractional_label() -> None:
    X, y, groups = toy_windows(90)
    classifier = find_estimator(LogisticRegression)(Task.CLASSIFICATION, RATE)
    with pytest.raises(InputError, match=r"28\.5") as refused:
        classifier.fit(X, np.where(y == 29, 28.5, y), groups)
    assert refused.value.parameter == "estimator"


@pytest.mark.parametrize(
    "regressor",
    [
        PIPELINE,
        RandomForestRegressor(5, random_state=0),
        HistGradientBoostingRegressor(max_iter=5, random_state=0),
        GaussianProcessRegressor(RBF() + WhiteKernel(), optimizer=None),
        make_pipeline(FunctionTransformer(np.abs), StandardScaler(), Ridge()),
    ],
)
def test_a_saved_model_predicts_the_same(regressor: Any, tmp_path: Path) -> None:
    X, y, groups = toy_windows(90)
    model = find_estimator(regressor)(Task.REGRESSION, RATE).fit(X, y, groups)
    loaded = load_window(save_window(model, tmp_path / "m"))
    assert isinstance(loaded, RegressorModel)
    np.testing.assert_array_equal(loaded.predict(X), model.predict(X))
    assert loaded.notes == model.notes


def test_train_takes_an_instance_and_a_name(data: Dataset, tmp_path: Path) -> None:
    instance = Ridge()
    predicted = []
    windows = ((0.005, 0.015), (0.015,), (0.015,))
    for number, estimator in enumerate((instance, Ridge, RIDGE)):
        model = fc.train(data, estimator=estimator, windows=windows[number])
        loaded = fc.load_model(model.save(tmp_path / str(number)))
        assert [w.model.kind for w in loaded.windows] == ["sklearn"] * len(windows[number])
        # The regressor predicts by default, and is named by its class or as it was given.
        assert loaded.estimators == ("Ridge", "combined")
        predictions = loaded.predict(data)
        assert predictions.estimator == "Ridge"
        values = predictions.value
        for name in (None, "Ridge", RIDGE):
            np.testing.assert_array_equal(values, model.predict(data, estimator=name).value)
        assert np.isfinite(values).all()
        predicted.append(values)
    assert fc.evaluate(loaded, data)[0].predictor == "Ridge"
    assert not hasattr(instance, "coef_")  # a copy was trained
    np.testing.assert_array_equal(predicted[0], predicted[1])
    np.testing.assert_array_equal(predicted[0], predicted[2])


@pytest.mark.parametrize("windows", [(0.015, 0.01501), (0.015, 0.015), ()])
def test_windows_with_the_same_samples_are_refused(data: Dataset, windows: Any) -> None:
    with pytest.raises(InputError) as refused:
        fc.train(data, "peak", windows=windows)
    assert refused.value.parameter == "windows"


def test_a_regressor_that_skops_does_not_trust_cannot_be_saved(
    data: Dataset, tmp_path: Path
) -> None:
    unnamed = make_pipeline(FunctionTransformer(lambda X: X), Ridge())
    # skops trusts the types of a search, but not those that the search adds in fit.
    search = GridSearchCV(Ridge(), {"alpha": [1.0, 10.0]})
    for estimator in (Mean, Mean(), unnamed, search):
        model = fc.train(data, estimator=estimator)
        with pytest.raises(InputError) as refused:
            model.save(tmp_path / "model")
        assert refused.value.parameter == "estimator"
        assert not (tmp_path / "model").exists()
    with pytest.raises(InputError) as refused:
        to_skops(Mean(), "Mean")
    assert f"{__name__}.Mean" in str(refused.value)


def test_a_regressor_that_needs_many_rows_is_trained(data: Dataset) -> None:
    assert fc.train(data, estimator=make_pipeline(PCA(40), Ridge())).windows


@pytest.mark.parametrize("estimator", [5, "no_such_module:Ridge", "sklearn.linear_model:Lasagne"])
def test_what_is_no_regressor_is_refused(data: Dataset, estimator: Any) -> None:
    with pytest.raises(InputError):
        fc.train(data, estimator=estimator)


def _rewritten(raw: bytes, tmp_path: Path, change: Any) -> bytes:
    source, target = tmp_path / "a.skops", tmp_path / "b.skops"
    source.write_bytes(raw)
    with ZipFile(source) as old, ZipFile(target, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            new.writestr(name, change(content) if name == "schema.json" else content)
    return target.read_bytes()


def test_a_file_with_an_untrusted_type_is_refused_with_its_name(tmp_path: Path) -> None:
    raw = to_skops(PIPELINE.fit(np.eye(3), np.arange(3)), "pipeline")

    def change(schema: bytes) -> bytes:
        tree = json.loads(schema)
        tree["__module__"], tree["__class__"] = "subprocess", "Popen"
        return json.dumps(tree).encode()

    with pytest.raises(InputError) as refused:
        from_skops(_rewritten(raw, tmp_path, change))
    assert "subprocess.Popen" in str(refused.value)


def test_a_damaged_file_is_refused(tmp_path: Path) -> None:
    raw = to_skops(PIPELINE.fit(np.eye(3), np.arange(3)), "pipeline")
    damaged = [
        b"",
        raw[: len(raw) // 2],
        _rewritten(raw, tmp_path, lambda schema: b"{}"),
        _rewritten(raw, tmp_path, lambda schema: schema.replace(b"Ridge", b"Rodge")),
    ]
    for content in damaged:
        with pytest.raises(InputError):
            from_skops(content)
