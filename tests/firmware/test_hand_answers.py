"""Predictions on the device, native and emulated, compared with the live pipeline's."""

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from device_process import running
from hand import FLOORS, chain_events, model_image, of_chain, of_device
from numpy.typing import NDArray
from test_emulated_device import emulated

from firstcontact.device.descriptor import DeviceEstimate, DevicePrediction
from firstcontact.device.flashing import flash_model
from firstcontact.device.serial_source import SerialSource
from firstcontact.export.hand_image import HandImage, hand_image
from firstcontact.streaming.twin import twin_model
from firstcontact.twin import TwinStream
from firstcontact.twin.sensor import DeviceFilter

SAMPLES = 30 * 4936


@pytest.fixture(scope="module")
def scans(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scans") / "twin.scans"
    TwinStream(seed=4).read(SAMPLES).tofile(path)
    return path


def read_until(
    path: str, enough: Callable[[int, list[DevicePrediction]], bool]
) -> tuple[NDArray[np.int16], list[DevicePrediction]]:
    """Read until ``enough`` of the number of samples and the messages is true. Return both."""
    blocks: list[NDArray[np.int16]] = []
    messages: list[DevicePrediction] = []
    patience = time.monotonic() + 120
    with SerialSource(path) as source:
        assert source.descriptor.predictor is not None
        while not enough(sum(map(len, blocks)), messages):
            assert time.monotonic() < patience
            for arrival in source.read(0.2):
                assert arrival.block.first_sample == sum(map(len, blocks))
                blocks.append(arrival.block.data)
                messages += arrival.predictions
    return np.concatenate(blocks), messages


@pytest.mark.parametrize(("kind", "least"), [("random", 50), ("default", 50), ("svm", 20)])
def test_native_device_predicts_as_the_chain_in_python(
    kind: str,
    least: int,
    strict_program: Path,
    images: tuple[HandImage, HandImage],
    scans: Path,
    tmp_path: Path,
) -> None:
    sent = images[0] if kind == "random" else model_image(1, "svr")
    if kind == "default":
        sent = hand_image(twin_model("paper-rig", 0), FLOORS)
    options = ("--scans", str(scans), "--speed", "5", "--ring", "65000")
    options += ("--models", str(tmp_path / "models"))
    with running(strict_program, *options) as device:
        assert flash_model(device.path, sent.data) == sent.digest
        data, messages = read_until(device.path, lambda n, _: n >= SAMPLES // 5 * 5)
    host = of_chain(chain_events(sent, data))
    answers = of_device(messages)
    assert len(host.contacts) >= 10
    assert len(host.estimates) >= least
    assert answers.contacts == host.contacts
    assert answers.estimates.items() <= host.estimates.items()
    # On a busy machine the device skips estimates that are late.
    assert len(answers.estimates) >= least // 2


def test_a_measured_speed_changes_the_estimates_as_in_python(
    program: Path, images: tuple[HandImage, HandImage], scans: Path, tmp_path: Path
) -> None:
    """The hint precedes all samples, so it counts for the first closing. Bad hints are ignored."""
    options = ("--scans", str(scans), "--speed", "2", "--ring", "65000")
    options += ("--models", str(tmp_path / "models"))
    data = TwinStream(seed=4).read(SAMPLES)
    plain = chain_events(images[0], DeviceFilter().update(data))
    hinted = chain_events(images[0], DeviceFilter().update(data), (0.3, 0.1, 0.01))
    assert of_chain(plain).estimates != of_chain(hinted).estimates
    with running(program, *options) as device:
        flash_model(device.path, images[0].data)
        with SerialSource(device.path) as source:
            source.hint(0.3, 0.1, 0.01)
            source.hint(-1.0, 0.1, 0.01)
            source.hint(float("nan"), 0.1, 0.01)
            messages: list[DevicePrediction] = []
            patience = time.monotonic() + 60
            while sum(isinstance(m, DeviceEstimate) for m in messages) < 3:
                assert time.monotonic() < patience
                messages += [p for arrival in source.read(0.2) for p in arrival.predictions]
    key, first = next(iter(of_device(messages).estimates.items()))
    assert first == of_chain(hinted).estimates[key] != of_chain(plain).estimates[key]


def test_emulated_board_predicts_as_the_chain_in_python_and_measures_its_time(
    image: Path, images: tuple[HandImage, HandImage], scans: Path, tmp_path: Path
) -> None:
    few = 24
    model = tmp_path / "hand.model"
    model.write_bytes(images[0].data)

    def enough(n: int, messages: list[DevicePrediction]) -> bool:
        # The device sends an estimate before the last sample that it used.
        estimates = [t for t in messages if isinstance(t, DeviceEstimate)]
        return len(estimates) >= few and n > estimates[few - 1].decided

    counted = ("-icount", "shift=10,sleep=off")
    with emulated(image, "counted", str(scans), str(model), more=counted) as path:
        data, messages = read_until(path, enough)
    estimates = [t for t in messages if isinstance(t, DeviceEstimate)][:few]
    host, device = of_chain(chain_events(images[0], data)), of_device(messages)
    last = estimates[-1].decided
    assert device.contacts[:1] == host.contacts[:1]
    for key, answer in device.estimates.items():
        if answer[-1] <= last:
            assert answer == host.estimates[key]
    # The first one includes the analysis of the pitch, and the report that there is none takes 0.
    times = [t.compute_time for t in estimates if not t.refused]
    assert 50e-6 < np.median(times) < 500e-6
