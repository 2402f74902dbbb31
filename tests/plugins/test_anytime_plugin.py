"""An any-time estimator of another package: one file, and one line that registers it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.cli.main import main
from firstcontact.core import InputError
from firstcontact.models import ESTIMATORS
from firstcontact.testing import check_anytime
from trainings import recordings

pytestmark = pytest.mark.usefixtures("stored_detectors")


def test_adapt_makes_saves_and_loads_it(tmp_path: Path) -> None:
    check_anytime(ESTIMATORS["rise_time"])
    pinches, folder = recordings(tmp_path / "p"), tmp_path / "model"
    data = fc.load(pinches)
    model = fc.adapt(data, estimator="rise_time")
    loaded = fc.load_model(model.save(folder))
    assert loaded.estimators == ("rise_time",)
    values = loaded.predict(data).value
    assert np.isfinite(values).any()
    np.testing.assert_array_equal(values, fc.train(data, "rise_time").predict(data).value)
    assert fc.evaluate(loaded, data)[0].scored == np.isfinite(values).sum()
    with pytest.raises(InputError, match="rise_time predicts in Python"):
        fc.export_model(model, tmp_path / "c")


@pytest.mark.parametrize("estimator", ["network", "combined"])
def test_estimators_of_the_package_pass_the_check(estimator: str) -> None:
    check_anytime(ESTIMATORS[estimator])


class Broken(ESTIMATORS["rise_time"].model):
    """Model that predicts recordings in another way."""

    def predict_pinches(self, data, contacts, at=1.0):
        made = super().predict_pinches(data, contacts, at)
        return replace(made, value=made.value + 1.0)


def test_a_model_that_differs_offline_fails_the_check() -> None:
    kind = ESTIMATORS["rise_time"]
    broken = type("Other", (kind,), {"model": Broken})

    def fit(self, *args, **kwargs):
        made, notes = kind.fit(self, *args, **kwargs)
        return Broken(made.line, made.error), notes

    broken.fit = fit
    with pytest.raises(AssertionError, match="live"):
        check_anytime(broken)


def test_the_verb_adapts_with_a_named_estimator(tmp_path: Path) -> None:
    pinches = recordings(tmp_path / "p")
    out = tmp_path / "model"
    assert main(["adapt", str(pinches), "--out", str(out), "--estimator", "network"]) == 0
    network = fc.load_model(out).network
    assert network.name == "network"


def test_adapt_refuses_what_it_cannot_use(tmp_path: Path) -> None:
    data = fc.load(recordings(tmp_path / "p"))
    with pytest.raises(InputError, match="learns from windows"):
        fc.adapt(data, estimator="svm")
    with pytest.raises(InputError, match="give at least one"):
        fc.adapt(estimator="network")
