"""The CNN as ONNX, run by ONNX Runtime on windows in volts."""

from pathlib import Path

import numpy as np
import pytest

from firstcontact.core import InputError
from firstcontact.core.installation import import_onnxruntime
from firstcontact.export import MODEL_EXPORTERS
from firstcontact.models import ESTIMATORS, Model, Task, make_estimator
from firstcontact.models.windows.window_predictor import WindowPredictor
from firstcontact.testing.synthetic import RATE, toy_windows


@pytest.mark.parametrize(
    "task", [Task.REGRESSION, pytest.param(Task.CLASSIFICATION, marks=pytest.mark.slow)]
)
def test_onnx_predicts_the_values_of_python(task: Task, tmp_path: Path) -> None:
    X, y, groups = toy_windows()
    model = make_estimator("cnn", task, RATE, **ESTIMATORS["cnn"].quick).fit(X, y, groups, seed=1)
    MODEL_EXPORTERS["onnx"].write(Model(None, (WindowPredictor(model),)), tmp_path)
    X = toy_windows(60, seed=8)[0]
    session = import_onnxruntime().InferenceSession(str(tmp_path / "stiffness.onnx"))
    (got,) = session.run(["prediction"], {"volts": X})
    if task is Task.CLASSIFICATION:
        np.testing.assert_array_equal(got.argmax(axis=1), model.choose(model.outputs(X)))
    else:
        np.testing.assert_allclose(got[:, 0], model.predict(X), rtol=1e-4)


def test_other_models_have_no_form_in_onnx(tmp_path: Path) -> None:
    X, y, groups = toy_windows()
    peak = make_estimator("peak", Task.REGRESSION, RATE).fit(X, y, groups, seed=1)
    for trained in (Model(), Model(None, (WindowPredictor(peak),))):
        with pytest.raises(InputError, match="--to c"):
            MODEL_EXPORTERS["onnx"].write(trained, tmp_path)
