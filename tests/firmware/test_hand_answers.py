"""Predictions on the device, native and emulated, compared with the live pipeline's."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from device_process import running
from hand import FLOORS, assert_same, host_events, of_device, of_host
from numpy.typing import NDArray
from test_emulated_device import emulated

from firstcontact.cli.main import main
from firstcontact.device import DeviceEstimate, DevicePrediction, SerialSource, flash_model
from firstcontact.export import FORMAT, hand_image
from firstcontact.twin import TwinStream
from firstcontact.twin._scans import write_scans

SAMPLES = 30 * 4936


@pytest.fixture
def folder(hand_models: tuple[Path, Path]) -> Path:
    return hand_models[0]


@pytest.fixture(scope="module")
def scans(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scans") / "twin.scans"
    write_scans(path, [TwinStream(seed=4).read(SAMPLES)])
    return path


def flash(path: str, folder: Path) -> None:
    image = hand_image(folder, FLOORS)
    assert flash_model(path, image.data, FORMAT, image.sizes) == image.digest


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


def test_native_device_predicts_as_live_does(
    strict_program: Path, folder: Path, scans: Path, tmp_path: Path
) -> None:
    options = ("--scans", str(scans), "--speed", "8", "--ring", "65000")
    options += ("--models", str(tmp_path / "models"))
    with running(strict_program, *options) as device:
        flash(device.path, folder)
        data, messages = read_until(device.path, lambda n, _: n >= SAMPLES // 5 * 5)
    host = of_host(host_events(folder, data))
    assert len(host.contacts) >= 10
    assert len(host.estimates) >= 50
    assert_same(of_device(messages), host)


def test_emulated_board_predicts_as_live_does_and_measures_its_time(
    image: Path, folder: Path, scans: Path, tmp_path: Path
) -> None:
    few = 24
    model = tmp_path / "hand.model"
    model.write_bytes(hand_image(folder, FLOORS).data)

    def enough(n: int, messages: list[DevicePrediction]) -> bool:
        # The device sends an estimate before the last sample that it used.
        estimates = [t for t in messages if isinstance(t, DeviceEstimate)]
        return len(estimates) >= few and n > estimates[few - 1].decided

    counted = ("-icount", "shift=10,sleep=off")
    with emulated(image, "counted", str(scans), str(model), more=counted) as path:
        data, messages = read_until(path, enough)
    estimates = [t for t in messages if isinstance(t, DeviceEstimate)][:few]
    host, device = of_host(host_events(folder, data)), of_device(messages)
    last = estimates[-1].decided
    assert device.contacts[:1] == host.contacts[:1]
    for key, (*numbers, strange, at) in device.estimates.items():
        if at <= last:
            *wanted, odd, complete = host.estimates[key]
            np.testing.assert_allclose(numbers, wanted, atol=0.01)
            assert (strange, at) == (odd, complete)
    # An estimate takes less than half of its millisecond, at 1.5 cycles per instruction.
    assert all(100e-6 < t.compute_time < 500e-6 for t in estimates)


def test_live_checks_the_devices_predictions_for_each_pinch(
    program: Path, folder: Path, scans: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ("--scans", str(scans), "--speed", "8", "--ring", "65000")
    options += ("--models", str(tmp_path / "models"))
    with running(program, *options) as device:
        flash(device.path, folder)
        arguments = ["--device", device.path, "--model", str(folder), "--pinches", "4", "--json"]
        assert main(["live", *arguments]) == 0
    messages = capsys.readouterr()
    lines = [json.loads(line) for line in messages.out.splitlines()]
    digest = hand_image(folder).digest
    assert f"with the model {digest}" in messages.err
    assert lines[0]["predictor"]["model"] == digest
    checked = [line for line in lines if line["type"] == "hand_pinch"]
    assert len(checked) >= 3
    assert all(line["check"]["same"] for line in checked)
    assert sum(line["check"]["compared"] for line in checked) >= 10
