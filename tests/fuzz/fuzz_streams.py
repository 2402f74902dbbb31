"""Damaged streams of live sources: samples, stamps, counters and metadata."""

from __future__ import annotations

import time
from collections import deque
from pathlib import Path
from queue import Empty
from random import Random
from types import SimpleNamespace
from typing import Any

import fuzz_mutate as mutate
import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Channel, ChannelKind, Layout
from firstcontact.device import Descriptor
from firstcontact.device._audio_source import AudioSource, _InputBlock
from firstcontact.device._csv_source import CsvSource
from firstcontact.device._lsl_source import LslSource
from firstcontact.device._number_lines import MOST, LineReader, identify_columns
from firstcontact.device._stamped_samples import StampedSamples
from firstcontact.device._threaded import LARGEST_SAMPLE, ThreadedSource

ODD = (np.nan, np.inf, -np.inf, 1e39, -1e300, 1e300, 2.0**31, 1e9, -1e9, 0.0)


def _spoiled(rng: Random, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the values, with none, some, consecutive or all of them replaced by odd values."""
    values = values.copy()
    kind = rng.randrange(5)
    begin = rng.randrange(len(values))
    for k in range(len(values)):
        if (kind == 1 and rng.random() < 0.1) or (kind == 2 and k >= begin) or kind == 3:
            values[k] = rng.choice(ODD)
    return values


def _hold(source: ThreadedSource) -> None:
    """Read a source and assert that it delivers valid samples."""
    ends: dict[int, int] = {}
    count = missing = 0
    for arrival in source.read(0.0):
        block = arrival.block
        assert np.isfinite(block.data).all(), "a sample that is not finite"
        assert np.abs(block.data).max() < 100 * LARGEST_SAMPLE, "a sample out of range"
        assert block.first_sample >= ends.get(block.epoch, 0), "a sample twice"
        missing += block.first_sample - ends.get(block.epoch, block.first_sample)
        ends[block.epoch] = block.end
        count += len(block.data)
    health = source.health
    assert health.samples == count, "samples that were not counted"
    assert missing <= health.lost_samples < 1e12, "losses that were not counted"
    if health.unusable_samples > 1:
        assert health.lost_samples, "unusable samples that are no loss"


def _worked(source: ThreadedSource) -> None:
    try:
        source._work()
    finally:
        _hold(source)


class _Port:
    """Port that delivers given bytes."""

    def __init__(self, source: CsvSource, data: bytes) -> None:
        self._source, self._data = source, data

    def read(self, patience: float) -> bytes:
        if not self._data:
            self._source._closing.set()
        data, self._data = self._data[:200], self._data[200:]
        return data

    def close(self) -> None:
        pass


def board(rng: Random, _: Path) -> None:
    """Read a board whose counter or signal is damaged in some lines, or in all later ones."""
    name = rng.choice(("count", "a", "a", "n"))
    numbers = np.arange(400.0) * rng.choice((1, 1, 1, -1, 0, 1e5))
    numbers = _spoiled(rng, numbers + rng.choice((0, 250, 65_500, 1e18)))
    signal = _spoiled(rng, np.sin(np.arange(400.0)))
    rows = [f"{n:.12g},{x!r}" for n, x in zip(numbers.tolist(), signal.tolist(), strict=True)]
    text = f"x\n{name},a\n" + "\n".join(rows) + "\n"
    data = text.encode() if rng.random() < 0.7 else mutate.raw(rng, text.encode())
    source = CsvSource("port", rng.choice(((), ("2",), ("a",), (mutate.text(rng),))))
    lines = [line for line in source._lines.feed(data[: len(data) // 4]) if line]
    if not lines:
        return
    source._columns = identify_columns(lines, source._lines.header, source._named, "port")
    source._lines = LineReader()
    source._resample(5000.0, 4936.0)
    disc = tuple(
        Channel(f"c{k}", ChannelKind.VIBRATION, None, "V")
        for k in range(len(source._columns.signals))
    )
    source._descriptor = Descriptor(Layout(disc, 4936.0), dtype="float32")
    source._port = _Port(source, data)  # type: ignore[assignment]
    _worked(source)


class _Node:
    """Part of a stream's description."""

    def __init__(self, labels: list[str]) -> None:
        self._labels = labels

    def child(self, _: str) -> _Node:
        return self

    def child_value(self, name: str) -> str:
        return self._labels[0] if self._labels and name == "label" else ""

    def next_sibling(self) -> _Node:
        return _Node(self._labels[1:])


class _Inlet:
    """Inlet that delivers given chunks."""

    def __init__(self, source: LslSource, info: Any, chunks: list[Any]) -> None:
        self._source, self._info, self._chunks = source, info, deque(chunks)

    def info(self, _: float) -> Any:
        return self._info

    def open_stream(self, _: float) -> None:
        pass

    close_stream = open_stream

    def time_correction(self, _: float) -> float:
        return 0.0

    def pull_chunk(self, **_: Any) -> Any:
        if not self._chunks:
            self._source._closing.set()
            return [], []
        return self._chunks.popleft()


def lsl(rng: Random, _: Path) -> None:
    """Read an LSL stream with odd labels, rates, values and stamps."""
    labels = [
        rng.choice(("disc", "1", mutate.text(rng))) for _ in range(rng.choice((0, 1, 1, 2, 2, 3)))
    ]
    rate = rng.choice((*[5000.0] * 20, 10_000.0, np.nan, np.inf, 0.0, -1.0, 1e300, 300.0))
    wanted = rng.choice(((), (), ("disc",), ("1",), ("9" * 5000,), ("1", "1"), ("\u0663",)))
    source = LslSource("fuzz", wanted)
    info = SimpleNamespace(
        nominal_srate=lambda: rate,
        channel_format=lambda: 2,
        channel_count=lambda: len(labels),
        desc=lambda: _Node(labels),
        name=lambda: mutate.text(rng),
        type=lambda: mutate.text(rng),
    )
    now, chunks = 1000.0, []
    for _ in range(rng.choice((1, 8, 30))):
        n = rng.choice((1, 2, 40))
        values = _spoiled(rng, np.sin(np.arange(float(n))))
        stamps = now + np.arange(n) / 5000.0
        stamps = _spoiled(rng, stamps) if rng.random() < 0.3 else stamps
        now += n / 5000.0 + (rng.choice((0.0, 3e-4, 0.1, -0.1, 1e4)) if rng.random() < 0.1 else 0.0)
        chunks.append((np.repeat(values[:, None], len(labels), axis=1), stamps.tolist()))
    source._lsl = SimpleNamespace(
        StreamInlet=lambda *_, **__: _Inlet(source, info, chunks),
        local_clock=lambda: now,
        cf_string=3,
    )
    source._descriptor = source._listen(info)
    assert not source._descriptor.layout.fault, source._descriptor.layout.fault
    _worked(source)


class _Blocks:
    """Queue of a sound input that delivers given blocks."""

    def __init__(self, source: AudioSource, blocks: list[_InputBlock]) -> None:
        self._source, self._blocks = source, deque(blocks)

    def get(self, timeout: float) -> _InputBlock:
        if not self._blocks:
            self._source._closing.set()
            raise Empty
        return self._blocks.popleft()


def sound(rng: Random, _: Path) -> None:
    """Read a sound input with odd samples, times and overflows."""
    source = AudioSource()
    source._resample(48_000.0, 4936.0)
    layout = Layout((Channel("microphone", ChannelKind.VIBRATION, None, ""),), 4936.0)
    source._descriptor = Descriptor(layout, dtype="float32")
    now, blocks = time.monotonic(), []
    for _ in range(rng.choice((1, 10, 40))):
        n = rng.choice((0, 1, 16, 256))
        values = _spoiled(rng, np.sin(np.arange(float(n)))) if n else np.zeros(0)
        with np.errstate(over="ignore"):
            data = values.astype(np.float32)[:, None]
        taken = now if rng.random() < 0.8 else rng.choice((*ODD, now - 5.0, now + 5.0))
        blocks.append(_InputBlock(data, taken, now, rng.random() < 0.1))
        now += n / 48_000.0
    source._blocks = _Blocks(source, blocks)  # type: ignore[assignment]
    _worked(source)


def lines(rng: Random, _: Path) -> None:
    """Feed lines of a board in pieces of any size. All numbers that are read must be finite."""
    between = rng.choice((",", ";", "\t", " ", ", "))
    rows = ["n", "left", "right"] if rng.random() < 0.5 else ["0", "1", "2"]
    text = between.join(rows) + "\n"
    for i in range(60):
        words = [str(i), str(rng.randrange(1024)), str(rng.randrange(1024))]
        if rng.random() < 0.1:
            words[rng.randrange(3)] = rng.choice((*mutate.TEXTS, *map(str, mutate.NUMBERS)))
        text += between.join(words) + rng.choice(("\n", "\r\n"))
    stream = text.encode(errors="replace")
    stream = mutate.raw(rng, stream) if rng.random() < 0.5 else stream
    reader, at = LineReader(), 0
    while at < len(stream):
        step = rng.choice((1, 7, 64, 100_000))
        for numbers in reader.feed(stream[at : at + step]):
            if numbers is not None:
                assert 0 < len(numbers) <= MOST
                assert np.isfinite(numbers).all(), "a number that is none"
        at += step


def stamps(rng: Random, _: Path) -> None:
    """Feed stamps that jump, stop, go back or are NaN. Sample numbers must still rise."""
    counted, last, now = StampedSamples(1000.0), -1, rng.choice((0.0, 1e9, -5.0))
    for _ in range(rng.choice((3, 60, 150))):
        n = rng.choice((1, 2, 40))
        if rng.random() < 0.1:
            now += rng.choice((-1.0, 0.5, 30.0, -1e4, 1e6))
        jitter = rng.choice((0.0, 1e-4, 5e-3))
        sample = now + np.arange(n) / 1000.0 + [jitter * rng.gauss(0, 1) for _ in range(n)]
        if rng.random() < 0.1:
            sample[rng.randrange(n)] = rng.choice((np.nan, np.inf, -np.inf, 1e300))
        now += n / 1000.0
        numbers = counted.numbers(sample)
        assert numbers[0] > last, "a number twice"
        assert (np.diff(numbers) > 0).all(), "numbers that do not rise"
        last = int(numbers[-1])
