"""A model predicts from signals in the unit of its training only."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from firstcontact.core import (
    Calibration,
    Channel,
    ChannelKind,
    Dataset,
    InputError,
    Label,
    Layout,
    Pinch,
    VibrationCalibration,
    fingertip_layout,
)
from firstcontact.models import adapt, evaluate, load_model, train
from firstcontact.recording.dataset import load_dataset, write_dataset
from firstcontact.recording.messages import Header
from toy_pinches import shore_dataset


def in_unit(data: Dataset, unit: str) -> Dataset:
    channels = tuple(replace(c, unit=unit) for c in data.layout.channels)
    layout = replace(data.layout, channels=channels)
    return replace(data, pinches=tuple(replace(p, layout=layout) for p in data.pinches))


@pytest.mark.parametrize("unit", ["counts", "full scale", ""])
def test_the_packages_model_marks_what_is_not_in_volts(
    unit: str, caplog: pytest.LogCaptureFixture
) -> None:
    data, model = shore_dataset(), adapt()
    assert not model.predict(data).out_of_range.all()
    assert "needs signals in V" not in caplog.text
    predictions = model.predict(in_unit(data, unit))
    assert (predictions.out_of_range | np.isnan(predictions.value)).all()
    (evaluation,) = evaluate(model, in_unit(data, unit))
    assert set(evaluation.groups[0].out_of_range.values()) == {1.0}
    assert "needs signals in V" in caplog.text


def test_a_trained_model_keeps_the_unit_of_its_sensor(tmp_path) -> None:
    own = in_unit(shore_dataset(), "full scale")
    model = load_model(train(own, "peak").save(tmp_path / "rig"))
    assert not model.is_foreign(own.layout)
    with pytest.raises(InputError, match="needs signals in full scale"):
        model.predict(shore_dataset())


@pytest.mark.parametrize(
    ("source", "scale", "is_foreign"),
    [("real", 1e-3, True), ("real", 3.3 / 1024, True), ("real", 1.0, False), ("twin", 1e-3, False)],
)
def test_a_model_without_unit_marks_converted_signals(
    source: str, scale: float, is_foreign: bool, caplog: pytest.LogCaptureFixture
) -> None:
    model = train(shore_dataset(), "peak")
    model = replace(model, trained_on=replace(model.trained_on, unit="", source=source))
    channel = Channel("piezo", ChannelKind.VIBRATION, None, "V", scale)
    assert model.is_foreign(Layout((channel,), 4936.0)) is is_foreign
    assert ("train again" in caplog.text) is is_foreign
    assert not model.is_foreign(fingertip_layout())


@pytest.mark.parametrize(
    ("unit", "middle", "scale"), [("counts", 512, 3.3 / 1024), ("mV", 0, 1e-3)]
)
def test_recordings_in_counts_or_mv_are_read_in_volts(
    unit: str, middle: float, scale: float, tmp_path: Path
) -> None:
    layout = Layout((Channel("piezo", ChannelKind.VIBRATION, None, unit),), 4936.0)
    data = (middle + np.arange(600) % 7).astype(np.float32)[:, None]
    known = Calibration((VibrationCalibration(None, 2.0, middle + 3.0),))
    pinch = Pinch(data, layout, Label("a", 50.0, session="1"), 0, calibration=known)
    write_dataset(
        Dataset((pinch,)), tmp_path, Header(layout, "real", dtype="float32", calibration=known)
    )
    (read,) = load_dataset(tmp_path).pinches
    assert (read.layout.vibration_unit, read.layout.channels[0].scale) == ("V", scale)
    assert read.calibration.piezo[0].noise == pytest.approx(2.0 * scale)
    assert read.calibration.piezo[0].offset == pytest.approx(3.0 * scale)
