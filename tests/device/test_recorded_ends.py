"""Tests that all received samples are recorded, however the run ends."""

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import pytest
from numbered import DESCRIPTOR, check
from scripted_device import ScriptedDevice

from firstcontact.collect.guide import Guide, Item
from firstcontact.collect.session import Screen, run_session
from firstcontact.contact import ThresholdDetector
from firstcontact.core import Block, Calibration, Finger, InputError, Layout, VibrationCalibration
from firstcontact.device import Descriptor
from firstcontact.device.serial_source import SerialSource
from firstcontact.grasp.printing import PrintHand
from firstcontact.recording import read_recording
from firstcontact.streaming import Event, Pipeline, Update
from firstcontact.streaming.session import LiveSession

#: Samples that a run takes at least, and that come while something is slow.
ENOUGH = 1000


def wait_for_samples(source: SerialSource, count: int) -> None:
    """Wait for more samples, or until the source is closed."""
    pause = threading.Event()
    until = source.health.samples + count
    while (health := source.health).connected and health.samples < until:
        pause.wait(1e-3)


class SlowViewer:
    """Sink that is slower than the samples."""

    name = "slow"
    every = 0.02

    def __init__(self, source: SerialSource) -> None:
        self._source = source

    def open(self, descriptor: Descriptor) -> None:
        """Ignore the call."""

    def take(self, update: Update) -> None:
        wait_for_samples(self._source, ENOUGH)

    def close(self) -> None:
        wait_for_samples(self._source, ENOUGH)


class SlowActor:
    """Handler of a hand that delays the session."""

    requests = None
    is_used = None
    hand = PrintHand()

    def __init__(self, source: SerialSource) -> None:
        self._source = source

    def on_samples(self, block: Block, host: float) -> None:
        wait_for_samples(self._source, ENOUGH // 10)

    def on_event(self, event: Event) -> None:
        """Ignore the call."""

    def take_commands(self) -> Sequence[Event]:
        return ()

    def after_block(self, block: Block) -> Sequence[Event]:
        return ()

    def ended(self) -> None:
        wait_for_samples(self._source, ENOUGH)


@pytest.fixture
def device(tmp_path: Path) -> Iterator[ScriptedDevice]:
    with ScriptedDevice(tmp_path / "port") as device, device.sending():
        yield device


@pytest.fixture
def source(device: ScriptedDevice) -> Iterator[SerialSource]:
    with SerialSource(device.port) as source:
        yield source


def check_recorded(path: Path, source: SerialSource) -> None:
    recording = read_recording(path)
    blocks = [Block(s.data, s.first_sample, s.epoch) for s in recording.stretches]
    # After the source was closed: nothing came later that only the count has.
    assert check(blocks) == source.health.samples >= ENOUGH


def interrupted(source: SerialSource, device: ScriptedDevice) -> dict[str, object]:
    return {"stopped": lambda: source.health.samples >= ENOUGH}


def limited(source: SerialSource, device: ScriptedDevice) -> dict[str, object]:
    wait_for_samples(source, ENOUGH)
    return {"seconds": 0.05}


def replaced(source: SerialSource, device: ScriptedDevice) -> dict[str, object]:
    """End the source as if another device were on its port."""
    wait_for_samples(source, ENOUGH)
    layout = DESCRIPTOR.layout
    other_descriptor = replace(DESCRIPTOR, layout=Layout(layout.channels, layout.rate + 1.0))
    device.reset(2, other_descriptor)
    return {}


@pytest.mark.parametrize("end", [interrupted, limited, replaced])
@pytest.mark.parametrize("reader", ["quick", "slow"])
def test_a_live_run_records_what_it_received(
    end: Callable[[SerialSource, ScriptedDevice], dict[str, object]],
    reader: str,
    source: SerialSource,
    device: ScriptedDevice,
    tmp_path: Path,
) -> None:
    pipeline = Pipeline(DESCRIPTOR.layout, ThresholdDetector(10.0))
    actor = SlowActor(source) if reader == "slow" else None
    session = LiveSession(source, pipeline, actor, recordings=tmp_path)  # type: ignore[arg-type]
    path = session.start_recording()
    with suppress(InputError):  # what became of the source is told, too
        session.run([SlowViewer(source)], **end(source, device))  # type: ignore[arg-type]
    check_recorded(path, source)


def test_a_guided_session_records_what_it_received(source: SerialSource, tmp_path: Path) -> None:
    calibration = Calibration(tuple(VibrationCalibration(f, 1.0) for f in Finger))
    guide = Guide(DESCRIPTOR.layout, (Item("block", 1, 10.0),), "1", calibration)
    header = DESCRIPTOR.header(session="1", calibration=calibration)
    path = tmp_path / "a.mcap"

    def stopped() -> bool:
        wait_for_samples(source, ENOUGH)
        return source.health.samples > 3 * ENOUGH

    assert not run_session(source, guide, path, header, Screen(), stopped)
    check_recorded(path, source)
