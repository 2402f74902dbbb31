"""Final model: its folds, and its interval, which uses the model's own spread if it has one."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from firstcontact.core import InputError
from firstcontact.jobs import Serial
from firstcontact.models import Task, load_model
from firstcontact.models.labelled_data import LabelledWindows
from firstcontact.models.training import train_final_model
from firstcontact.testing.synthetic import RATE, toy_windows
from saved import save_window

pytestmark = pytest.mark.usefixtures("stored_detectors")


def labelled(
    X: NDArray[np.float32], y: NDArray[np.float64], sessions: NDArray[np.str_]
) -> LabelledWindows:
    rows = np.arange(len(X))
    none = np.full(len(X), "")
    return LabelledWindows(X, y, sessions, none, none, np.zeros(len(X), bool), rows, RATE)


@pytest.mark.parametrize("task", Task)
def test_one_level_to_learn_from_is_refused(task: Task) -> None:
    X, y, sessions = toy_windows(60)
    two = np.where(y > 10, 60.0, 10.0)
    for levels, groups in ((np.full(60, 10.0), sessions), (two, two.astype(str))):
        with pytest.raises(InputError) as refused:
            train_final_model(labelled(X, levels, groups), "peak", task, 0, 0.9, Serial())
        assert refused.value.parameter == "data"


@pytest.mark.parametrize("task", Task)
def test_folds_that_leave_one_level_are_not_scored(task: Task) -> None:
    X, y, sessions = toy_windows(60)
    levels = np.where(y > 10, 60.0, 10.0)
    groups = np.where(levels > 10, "hard", sessions)
    final = train_final_model(labelled(X, levels, groups), "peak", task, 0, 0.9, Serial())
    assert 0 < final.scores.n <= np.sum(levels == 10)
    assert "1 fold not scored" in final.split


def test_a_gaussian_process_is_kept_with_its_own_spread(tmp_path: Path) -> None:
    data = labelled(*toy_windows(300))
    X = data.X
    selected = train_final_model(data, "gaussian_process", Task.REGRESSION, 0, 0.9, Serial())
    assert selected.interval.scaled
    assert selected.conformal["held_out"]["coverage"] == pytest.approx(0.9, abs=0.06)
    folder = save_window(selected.model, tmp_path / "m", interval=selected.interval)
    [window] = load_model(folder).windows
    model, interval = window.model, window.interval
    value, spread = model.predict(X[:1])[0], model.spread(X[:1])
    low, high = interval.around(value, float(spread[0]))
    assert low < value < high
    assert interval.level == 0.9
