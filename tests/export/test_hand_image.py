"""The image for a hand holds the whole default model, and predicts as the model does."""

from dataclasses import replace
from pathlib import Path

import pytest
from test_model_parity import learned

from firstcontact.chain import Chain, EventKind, Image, build_image
from firstcontact.core import Block, Calibration, InputError, VibrationCalibration, fingertip_layout
from firstcontact.export.hand_image import hand_image
from firstcontact.models import Task, load_model
from firstcontact.streaming.twin import twin_model
from firstcontact.twin import TwinStream
from firstcontact.twin.sensor import DeviceFilter


def test_default_model_with_a_rig_of_each_finger_fits_and_gives_the_events_of_the_computer() -> (
    None
):
    folder = twin_model("paper-rig", 0)
    model = load_model(folder)
    assert model.network is not None
    network = model.network
    assert (network.name, set(network.regressions)) == ("combined", {-1, 0, 1})
    data = hand_image(folder).data
    assert len(data) < 256 * 1024
    whole = build_image(
        network.rate, model.own_detector.chain_constants(network.rate), network.chain_constants()
    )
    layout = fingertip_layout()
    floors = [VibrationCalibration(finger, 0.0018) for finger in layout.vibration_fingers]
    samples = Block(DeviceFilter().update(TwinStream(seed=2).read(8 * 4936)))
    ours, theirs = (
        [tuple(event) for event in Chain(image, layout, Calibration(tuple(floors))).take(samples)]
        for image in (whole, Image(data))
    )
    assert ours == theirs
    assert sum(event[0] == EventKind.ESTIMATED for event in ours) > 20


@pytest.mark.usefixtures("small_searches")
def test_a_hand_gets_the_estimator_that_predicts_by_default_or_the_chosen_one(
    tmp_path: Path,
) -> None:
    adapted = load_model(twin_model("paper-rig", 0))
    svm, peak = (learned(name, Task.REGRESSION) for name in ("svm", "peak"))
    both = replace(adapted, predictors=(svm, peak, *adapted.predictors))
    both.write(tmp_path)
    network = hand_image(twin_model("paper-rig", 0)).digest
    assert hand_image(tmp_path, estimator="combined").digest == network
    chosen = hand_image(tmp_path)
    assert chosen.digest == hand_image(tmp_path, estimator="svm").digest != network
    assert b'"anytime":"svm"' in chosen.data
    with pytest.raises(InputError, match="peak predicts in Python"):
        hand_image(tmp_path, estimator="peak")
