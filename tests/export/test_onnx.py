"""Window models as ONNX, run by ONNX Runtime."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from estimator_tasks import EACH
from firstcontact.core import INPUT, InputError, import_onnxruntime
from firstcontact.export import NamedModel, Trained
from firstcontact.export import _onnx_graph as onnx_graph
from firstcontact.models import ESTIMATORS, Task, make_estimator
from firstcontact.testing._windows import RATE, toy_windows


@pytest.mark.parametrize(("name", "task"), EACH)
def test_onnx_answers_as_python_does(name: str, task: Task, tmp_path: Path) -> None:
    X, y, groups = toy_windows()
    model = make_estimator(name, task, RATE, **ESTIMATORS[name].quick).fit(X, y, groups, seed=1)
    onnx_graph.write(Trained((NamedModel("stiffness", model, None),)), tmp_path)
    # Others than it learned from: thresholds of MiniRocket are values of those, to the last bit.
    X = toy_windows(60, seed=8)[0]
    session = import_onnxruntime().InferenceSession(str(tmp_path / "stiffness.onnx"))
    got = session.run(None, {INPUT: X.reshape(len(X), -1)})
    if task is Task.CLASSIFICATION:
        np.testing.assert_array_equal(got[0].argmax(axis=1), model.choose(model.outputs(X)))
        return
    np.testing.assert_allclose(got[0][:, 0], model.outputs(X)[:, 0], atol=1e-3)
    spread = model.spread(X)
    if spread is not None:
        np.testing.assert_allclose(got[1][:, 0], spread, rtol=1e-3)


def test_a_training_without_a_model_of_a_window_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--to c"):
        onnx_graph.write(Trained(), tmp_path)
