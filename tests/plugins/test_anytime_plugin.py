"""An any-time estimator of another package: one file, and one line that registers it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.cli.main import main
from firstcontact.core import InputError
from firstcontact.models import ESTIMATORS
from trainings import recordings

pytestmark = pytest.mark.usefixtures("stored_detectors")


def test_adapt_makes_saves_and_loads_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(ESTIMATORS._own, "one_rig", "more_estimators.one_rig:OneRig")
    pinches, folder = recordings(tmp_path / "p"), tmp_path / "model"
    data = fc.load(pinches)
    model = fc.adapt(data, estimator="one_rig")
    model.save(folder)
    loaded = fc.load_model(folder)
    assert loaded.network is not None
    assert loaded.network.name == "one_rig"
    values = loaded.predict(data).value
    assert np.isfinite(values).any()
    np.testing.assert_array_equal(values, model.predict(data).value)
    np.testing.assert_array_equal(values, fc.train(data, "one_rig").predict(data).value)
    monkeypatch.delitem(ESTIMATORS._own, "one_rig")
    ESTIMATORS._loaded.pop("one_rig")
    with pytest.raises(InputError, match="one_rig"):
        fc.load_model(folder)


def test_the_verb_adapts_with_a_named_estimator(tmp_path: Path) -> None:
    pinches = recordings(tmp_path / "p")
    out = tmp_path / "model"
    assert main(["adapt", str(pinches), "--out", str(out), "--estimator", "network"]) == 0
    network = fc.load_model(out).network
    assert network is not None
    assert network.name == "network"


def test_adapt_refuses_what_it_cannot_use(tmp_path: Path) -> None:
    data = fc.load(recordings(tmp_path / "p"))
    with pytest.raises(InputError, match="learns from windows"):
        fc.adapt(data, estimator="svm")
    with pytest.raises(InputError, match="give some"):
        fc.adapt(estimator="network")
