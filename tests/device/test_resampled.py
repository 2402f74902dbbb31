"""Tests of resampling: samples, sample numbers, markers, marks and counts fit together."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firstcontact.core import (
    Block,
    ChannelKind,
    ClosingSpeed,
    Contact,
    Finger,
    InputError,
    fingertip_layout,
)
from firstcontact.device import Arrival
from firstcontact.device.replay import ReplaySource
from firstcontact.device.resampled import ResampledSource
from firstcontact.device.source import drain
from firstcontact.recording import Header, Marker, PinchMark, RecordingWriter
from firstcontact.signal import resample

NEW = 4936.0


def write_recording(rate: float, folder: Path, stretches: list[Block], *marks: PinchMark) -> Path:
    path = folder / "a.mcap"
    layout = replace(fingertip_layout(), rate=rate)
    with RecordingWriter(path, Header(layout, "synthetic")) as writer:
        for block in stretches:
            writer.write(block)
            writer.marker(Marker(block.first_sample, "begins", block.epoch))
            writer.marker(Marker(block.end - 1, "ends", block.epoch))
        for mark in marks:
            writer.mark(mark)
    return path


def samples(count: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    data = rng.normal(16_000, 900, (count, 16)).astype(np.int16)
    strips = list(fingertip_layout().columns(ChannelKind.STRIP))
    data[:, strips] = np.repeat(rng.integers(0, 2, (count // 50 + 1, 2)), 50, axis=0)[:count]
    return data


def read_all(source: ResampledSource) -> list[Arrival]:
    arrivals = []
    while not source.ended:
        arrivals += source.read(1.0)
    return arrivals + drain(source)


@settings(max_examples=12, deadline=None)
@given(
    rate=st.sampled_from([8000.0, 2500.0, 48_000.0]),
    block=st.integers(1, 700),
    gap=st.integers(1, 900),
    seed=st.integers(0, 99),
)
def test_samples_marks_and_counts_have_the_new_rate(
    rate: float, block: int, gap: int, seed: int
) -> None:
    stretches = [
        Block(samples(1500, seed), 0, 0),
        Block(samples(1100, seed + 1), 1500 + gap, 0),
        Block(samples(900, seed + 2), 0, 1),
    ]
    truth = (Contact(Finger.INDEX, 400, 400),)
    mark = PinchMark(0, 100, 900, 1, truth=truth, motor_start=200)
    with TemporaryDirectory() as folder:
        path = write_recording(rate, Path(folder), stretches, mark)
        with ReplaySource(path, speed=np.inf, block=block) as inner:
            source = ResampledSource(inner, NEW)
            descriptor = source.descriptor
            arrivals = read_all(source)
            health = source.health
    assert (descriptor.layout.rate, descriptor.dtype) == (NEW, "float32")
    assert 0 < descriptor.delay <= 0.0005
    share = NEW / rate
    all_values = np.concatenate([a.block.data for a in arrivals])
    assert all_values.dtype == np.float32
    assert health.samples == len(all_values)
    assert health.lost_samples == pytest.approx(gap * share, abs=0.0005 * NEW + 3)
    missing = 0
    for arrival, next_arrival in pairwise(arrivals):
        if arrival.block.epoch == next_arrival.block.epoch:
            missing += next_arrival.block.first_sample - arrival.block.end
            assert next_arrival.block.first_sample >= arrival.block.end
    assert health.lost_samples == missing
    # The first stretch begins with sample 0 of both rates: its samples are those of resample().
    begin = [a.block for a in arrivals if a.block.epoch == 0]
    values = np.concatenate([b.data for b in begin if b.end <= 1500 * share])
    analogue = [k for k in range(16) if k not in descriptor.layout.columns(ChannelKind.STRIP)]
    offline = resample(stretches[0].data, rate, NEW)
    np.testing.assert_allclose(
        values[:, analogue], offline[: len(values)][:, analogue], rtol=1e-4, atol=0.5
    )
    assert len(values) >= (1500 - block - 0.0005 * rate) * share - 3
    strips = list(descriptor.layout.columns(ChannelKind.STRIP))
    nearest = np.rint(np.arange(len(values)) / share).astype(int)
    is_equal = values[:, strips] == stretches[0].data[nearest][:, strips]
    assert is_equal.mean() > 0.999  # instants half way between two samples have two nearest ones
    assert set(np.unique(all_values[:, strips])) <= {0.0, 1.0}
    # Each word and mark comes once, in its epoch, at its instant.
    words = [m for a in arrivals for m in a.markers]
    assert all(m.epoch == a.block.epoch for a in arrivals for m in a.markers)
    expected = [(s * share, e) for b in stretches for s, e in ((b.first_sample, b.epoch),)]
    begins = [(m.sample, m.epoch) for m in words if m.text == "begins"]
    assert [e for _, e in begins] == [e for _, e in expected]
    np.testing.assert_allclose([s for s, _ in begins], [s for s, _ in expected], atol=0.51)
    assert [m.text for m in words].count("ends") == len(stretches)
    ((place, moved),) = [(a, p) for a in arrivals for p in a.pinches]
    assert place.block.epoch == moved.epoch == 1
    numbers = (moved.first_sample, moved.motor_start, moved.truth[0].sample, moved.end)
    np.testing.assert_allclose(numbers, np.array([100, 200, 400, 900]) * share, atol=0.51)


@pytest.mark.parametrize("rate", [8000.0, 2500.0])
def test_closing_speeds_are_those_of_the_source(rate: float, tmp_path: Path) -> None:
    speeds = [ClosingSpeed(0.12, 0.003), ClosingSpeed(0.2)]
    spans = [(100, 900), (900, 1400)]
    marks = [
        PinchMark(number, *span, 0, closing_speed=speed)
        for number, (span, speed) in enumerate(zip(spans, speeds, strict=True))
    ]
    path = write_recording(rate, tmp_path, [Block(samples(1500, 0), 0, 0)], *marks)
    with ReplaySource(path, speed=np.inf) as inner:
        source = ResampledSource(inner, NEW)
        for old in range(0, 1500, 40):
            new = round((old + 20) * NEW / rate)
            assert source.closing_speed(new, 0) == inner.closing_speed(old + 20, 0)
            assert source.closing_speed(new, 1) is None
        answers = {source.closing_speed(round(n * NEW / rate), 0) for n in range(1500)}
    assert answers == {*speeds, None}


@pytest.mark.parametrize("rate", [400.0, 9_999_999.0])
def test_rates_without_a_resampler_are_refused(rate: float, tmp_path: Path) -> None:
    path = write_recording(rate, tmp_path, [Block(samples(60, 0), 0, 0)])
    with ReplaySource(path) as inner, pytest.raises(InputError, match=f"{NEW:g} Hz"):
        ResampledSource(inner, NEW)
