"""Training pinches of an export: any rate, and at least one pinch."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.core import Role
from firstcontact.export import MODEL_EXPORTERS, ModelExporter, Trained
from firstcontact.models import Model, NetworkPredictor
from firstcontact.models._rig_speeds import RigSpeeds
from firstcontact.signal import resample_dataset

pytestmark = pytest.mark.usefixtures("stored_detectors")


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> fc.Dataset:
    folder = tmp_path_factory.mktemp("export") / "pinches"
    return fc.simulate(folder, pinches_per_block=12, pinches_per_object=2, seed=1)


@pytest.fixture(scope="module")
def model(data: fc.Dataset) -> fc.Model:
    return fc.adapt(data)


def test_a_network_is_made_compact_at_its_own_rate(
    data: fc.Dataset, model: fc.Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written: list[Trained] = []

    def write(trained: Trained, folder: Path) -> list[str]:
        written.append(trained)
        return []

    exporter = ModelExporter("c", write)
    monkeypatch.setattr(MODEL_EXPORTERS, "find", lambda name: exporter)
    for rate in (model.rate, 4890.0, 10_000.0):
        recorded = replace(resample_dataset(data, rate), recorded_rate=None)
        fc.export_model(model, tmp_path / f"{rate:g}", data=recorded)
    objects = data[data.test]
    values = []
    for trained in written:
        assert trained.anytime is not None
        compact = Model(predictors=(NetworkPredictor(trained.anytime),))
        values.append(compact.predict(objects, contacts="known").value)
    for other in values[1:]:  # without resampling, it is 1.3 Shore A at 10 kHz
        assert np.nanmean(np.abs(other - values[0])) < 0.9


def test_speeds_that_the_export_leaves_out_are_named(
    data: fc.Dataset, model: fc.Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(MODEL_EXPORTERS, "find", lambda name: ModelExporter("c", lambda *_: []))
    assert model.network is not None
    network = model.network.model.network_alone()
    for speeds in (RigSpeeds(0.1), None):
        rigs = {f: replace(rig, speeds=speeds) for f, rig in network.rigs.items()}
        with_rigs = Model(model.detector, (NetworkPredictor(network.conditioned_on(rigs)),))
        lines = fc.export_model(with_rigs, tmp_path / str(speeds is None), data=data)
        assert len([line for line in lines if "closing speeds" in line]) == (speeds is not None)


def test_an_export_without_training_pinches_is_refused(
    data: fc.Dataset, model: fc.Model, tmp_path: Path
) -> None:
    unseen = data[data.test]
    assert all(p.label.role is Role.TEST for p in unseen)
    for pinches in (data[:0], unseen):
        with pytest.raises(fc.InputError) as caught:
            fc.export_model(model, tmp_path / "c", to="c", data=pinches)
        assert caught.value.parameter == "data"
        assert not (tmp_path / "c").exists()
