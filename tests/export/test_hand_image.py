"""The image for a hand holds the whole default model, and predicts as the model does."""

from __future__ import annotations

from firstcontact.chain import Chain, EventKind, Image, build_image
from firstcontact.core import Block, Calibration, VibrationCalibration, fingertip_layout
from firstcontact.export.hand_image import hand_image
from firstcontact.models import load_model
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
        network.rate, model.own_detector.constants(network.rate), network.constants()
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
