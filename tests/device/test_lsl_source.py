"""Tests of LSL streams in another process: regular, jittering, killed and restarted."""

from __future__ import annotations

import subprocess
import uuid
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from lsl_outlet_of import sending

from firstcontact.core import InputError
from firstcontact.device import Arrival, SourceOptions
from firstcontact.device._lsl_source import LslSource, from_name
from firstcontact.device._stamped_samples import LEAST

pylsl = pytest.importorskip("pylsl")


@pytest.fixture
def name() -> str:
    return f"a test {uuid.uuid4().hex}"


def until(source: LslSource, samples: int, epoch: int = 0) -> list[Arrival]:
    arrivals: list[Arrival] = []
    while sum(len(a.block.data) for a in arrivals if a.block.epoch == epoch) < samples:
        arrivals += source.read(5.0)
    return arrivals


def counts_and_numbers(arrivals: list[Arrival]) -> tuple[np.ndarray, np.ndarray]:
    """Return the stream's own counts, and the sample numbers of the source."""
    values = np.concatenate([a.block.data[:, 0] for a in arrivals]).astype(np.float64)
    numbers = np.concatenate([np.arange(a.block.first_sample, a.block.end) for a in arrivals])
    return values, numbers


@pytest.mark.parametrize("jitter", [0.0, 2.0])
def test_jittering_stream_has_no_losses(name: str, jitter: float) -> None:
    with sending(name, jitter=jitter), LslSource(name, ("count",)) as source:
        arrivals = until(source, 4000)
    values, numbers = counts_and_numbers(arrivals)
    assert source.health.lost_samples == 0
    np.testing.assert_array_equal(np.diff(values), 1.0)
    np.testing.assert_array_equal(np.diff(numbers), 1)


def test_skipped_samples_are_lost_at_their_place(name: str) -> None:
    with sending(name, lose_at=2000, lose=37), LslSource(name, ("count",)) as source:
        arrivals = until(source, 4000)
    values, numbers = counts_and_numbers(arrivals)
    assert source.health.lost_samples == 37
    assert len(set(values - numbers)) == 1


def test_gap_in_a_jittering_stream_has_about_its_length(name: str) -> None:
    with (
        sending(name, jitter=1.0, lose_at="line", lose=500) as outlet,
        LslSource(name, ("count",)) as source,
    ):
        # Samples that waited for a late reader come in few large chunks, which show no gap.
        arrivals = until(source, 1000)
        while len(arrivals) < 2 * LEAST:
            arrivals += source.read(5.0)
        assert outlet.stdin is not None
        print(file=outlet.stdin, flush=True)
        arrivals += until(source, 5000)
    values, numbers = counts_and_numbers(arrivals)
    assert source.health.lost_samples == pytest.approx(500, abs=15)
    # Its count has the truth: in the end numbers are off by no more than that.
    assert abs((values[-1] - values[0]) - (numbers[-1] - numbers[0])) <= 15


def test_restarted_stream_is_another_epoch(name: str) -> None:
    with outlet_and_source(name) as (source, outlet):
        until(source, 500)
        outlet.kill()
        while source.health.connected:
            source.read(0.05)
        with sending(name):
            arrivals = until(source, 500, epoch=1)
            assert source.health.connected
            assert source.health.reconnects == 1
    values, numbers = counts_and_numbers([a for a in arrivals if a.block.epoch == 1])
    assert numbers[0] == 0
    np.testing.assert_array_equal(np.diff(values), 1.0)


@contextmanager
def outlet_and_source(name: str) -> Iterator[tuple[LslSource, subprocess.Popen[str]]]:
    with sending(name) as outlet, LslSource(name, ("count",)) as source:
        yield source, outlet


def test_vibration_channel_is_found_by_type_and_resampled(name: str) -> None:
    with sending(name, rate=10_000.0), LslSource(name) as source:
        layout = source.descriptor.layout
        assert layout.column_names == ("disc",)
        assert (layout.rate, layout.channels[0].unit) == (4936.0, "V")
        assert 0 < source.descriptor.delay <= 0.0005
        values, _ = counts_and_numbers(until(source, 1000))
    assert np.abs(values[200:]).max() == pytest.approx(1.0, abs=0.01)


def test_unusable_streams_are_refused(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="lsl:NAME"):
        from_name("lsl:", SourceOptions())
    with sending(name), pytest.raises(InputError, match="count, disc"):
        LslSource(name, ("violin",)).__enter__()
    with sending(name, rate=100.0), pytest.raises(InputError, match=r"\b494\b"):
        LslSource(name).__enter__()
    with sending(name, rate=2e6), pytest.raises(InputError, match=r"1e\+06"):
        LslSource(name).__enter__()
    monkeypatch.setattr("firstcontact.device._lsl_source.PATIENCE", 0.2)
    with pytest.raises(InputError, match="nobody"):
        LslSource("nobody sends this").__enter__()


@pytest.mark.parametrize("kind", ["LostError", "TimeoutError", "InternalError"])
def test_library_errors_about_a_dead_sender_are_input_errors(
    name: str, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """LSL reports a dead sender in three ways, depending on the state of its socket."""

    def refuse(self: object, timeout: float = 0.0) -> object:
        raise getattr(pylsl.util, kind)("connection refused")

    outlet = pylsl.StreamOutlet(pylsl.StreamInfo(name, "Piezo", 1, 4936.0, pylsl.cf_float32))
    monkeypatch.setattr(pylsl.StreamInlet, "info", refuse)
    with pytest.raises(InputError), LslSource(name):
        pass
    del outlet
