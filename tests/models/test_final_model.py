"""Final model: its interval uses the model's own spread if there is one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from firstcontact.core import Serial
from firstcontact.models import (
    LabelledWindows,
    Task,
    load_model,
    train_final_model,
)
from firstcontact.testing._windows import RATE, toy_windows
from saved import save_window

pytestmark = pytest.mark.usefixtures("stored_detectors")


def test_a_gaussian_process_is_kept_with_its_own_spread(tmp_path: Path) -> None:
    X, y, groups = toy_windows(300)
    rows = np.arange(len(X))
    none = np.full(len(X), "")
    data = LabelledWindows(X, y, groups, none, none, np.zeros(len(X), bool), rows, RATE)
    selected = train_final_model(data, "gaussian_process", Task.REGRESSION, 0, 0.9, Serial())
    assert selected.interval is not None
    assert selected.interval.scaled
    assert selected.conformal["held_out"]["coverage"] == pytest.approx(0.9, abs=0.06)
    folder = save_window(selected.model, tmp_path / "m", interval=selected.interval)
    [window] = load_model(folder).windows
    model, interval = window.model, window.interval
    assert interval is not None
    value, spread = model.predict_one(X[0]), model.spread(X[:1])
    assert spread is not None
    low, high = interval.around(value, float(spread[0]))
    assert low < value < high
    assert interval.level == 0.9
