"""Tests of unusable samples in sources with a thread."""

import re
import threading
import time

import numpy as np
import pytest

from firstcontact.core import Channel, ChannelKind, InputError, Layout
from firstcontact.device import Arrival, Descriptor
from firstcontact.device.threaded import ThreadedSource
from processes import PATIENCE

RATE, INPUT_RATE = 4936.0, 5000.0
#: Samples that one bad sample may cost: itself, and what the filter needs to begin again.
COST = 3


class Scripted(ThreadedSource):
    """Source that delivers given samples as fast as possible, then nothing."""

    def __init__(self, values: np.ndarray, epochs: np.ndarray | None = None) -> None:
        super().__init__("scripted")
        self.values = values
        self.epochs = np.zeros(len(values), int) if epochs is None else epochs
        self.done = threading.Event()

    def _open(self) -> Descriptor:
        delay = self._resample(INPUT_RATE, RATE)
        disc = Channel("disc", ChannelKind.VIBRATION, None, "V")
        return Descriptor(Layout((disc,), RATE), dtype="float32", delay=delay)

    def _work(self) -> None:
        for epoch in np.unique(self.epochs):
            values = self.values[self.epochs == epoch, None]
            for start in range(0, len(values), 25):
                part = values[start : start + 25]
                numbers = np.arange(start, start + len(part))
                self._give(part, numbers, int(epoch), time.monotonic())
        self.done.set()
        while not self._closing.wait(0.005):
            self._wait()

    def _shut(self) -> None:
        pass


def read_to_end(source: Scripted) -> list[Arrival]:
    with source:
        assert source.done.wait(PATIENCE)
        return source.read(0.0)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e39, 1e300, -1e12])
def test_bad_sample_costs_itself_and_the_filter_length(bad: float) -> None:
    values = np.sin(np.arange(5000) / 9)
    values[2500] = bad
    source = Scripted(values)
    arrivals = read_to_end(source)
    data = np.concatenate([a.block.data for a in arrivals])
    end = arrivals[-1].block.end
    assert np.abs(data).max() < 1.5
    assert 1 <= end - len(data) == source.health.lost_samples <= COST
    assert source.health.unusable_samples == 1


def test_losses_around_an_epoch_change_are_counted() -> None:
    values = np.sin(np.arange(5000) / 9)
    values[2000:3500] = 1e39
    source = Scripted(values, np.repeat([0, 1], 2500))
    read_to_end(source)
    health = source.health
    assert health.reconnects == 1
    assert health.samples + health.lost_samples == pytest.approx(RATE, abs=2)


class Unusable(Scripted):
    """Source that never delivers a number."""

    def _work(self) -> None:
        end = 0
        while not self._closing.wait(0.005):
            end += 25
            self._give(np.full((25, 1), np.nan), np.arange(end - 25, end), 0, time.monotonic())


def test_unusable_stream_is_refused() -> None:
    source = Unusable(np.zeros(0))
    began = time.monotonic()
    with source, pytest.raises(InputError, match=f"{re.escape(source.name)} .*no usable"):
        source.read(PATIENCE)
    assert time.monotonic() - began < PATIENCE / 2
    assert source.health.samples == 0
    assert source.health.lost_samples > 1000


def test_silence_is_detected_but_not_in_a_suspended_process() -> None:
    source = Scripted(np.zeros(500))
    with source:
        assert source.done.wait(PATIENCE)
        assert source.health.connected
        assert sum(len(a.block.data) for a in source.read(0.0)) > 400
        assert source.read(0.3) == []
        assert source.health.connected
        began = time.monotonic()
        while source.health.connected:
            assert time.monotonic() - began < PATIENCE
            source.read(0.01)
