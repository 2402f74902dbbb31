"""An any-time estimator of another package: one file, and one line that registers it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.cli.main import main
from firstcontact.contact.detector_file import pretrained_detector
from firstcontact.core import Block, Dataset, InputError
from firstcontact.models import ESTIMATORS, Model, Predictions, RigPredictor, Touches
from firstcontact.models.in_context import InContextModel
from firstcontact.models.model_file import pretrained
from firstcontact.streaming import Pipeline
from firstcontact.streaming.predictors import live_predictor
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


class HalvedModel(InContextModel):
    """Network whose predictions Python halves."""

    kind = "halved"

    def predict(self, touches: Touches) -> Predictions:
        made = super().predict(touches)
        return replace(made, value=made.value / 2)


def test_a_prediction_in_python_is_the_same_live_and_cannot_run_on_a_hand(tmp_path: Path) -> None:
    base = pretrained()
    own = HalvedModel(base.network, base.familiar, base.factors, base.level, base.rigs, base.mixed)
    model = Model(pretrained_detector(), (RigPredictor(own),))
    data = fc.simulate(tmp_path / "p", pinches_per_block=2, pinches_per_object=0)
    compared = 0
    for pinch in data.pinches:
        one, predictor = Dataset((pinch,)), live_predictor(model)
        live = Pipeline(pinch.layout, model.own_detector, predictor, real_time=False)
        events = list(live.update(Block(pinch.data, pinch.first_sample), 0.0)) + live.finish()
        for event in events:
            if isinstance(event, fc.Estimate):
                offline = model.predict(one, event.elapsed + 9e-5, [event.contact])
                if offline.elapsed[0] == event.elapsed:
                    assert (event.value, event.low) == (offline.value[0], offline.low[0])
                    compared += 1
    assert compared > 20
    with pytest.raises(InputError, match="halved predicts in Python"):
        fc.export_model(model, tmp_path / "c")


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
    with pytest.raises(InputError, match="give at least one"):
        fc.adapt(estimator="network")
