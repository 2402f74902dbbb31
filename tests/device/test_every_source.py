"""Tests of all registered kinds of sources. For a new kind, add a device to the list here."""

import math
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from uuid import uuid4

import numpy as np
import pytest
from lsl_outlet import sending
from printing_board import PrintingBoard
from scipy.io import wavfile

from firstcontact.core import Block, InputError, fingertip_layout
from firstcontact.core.installation import load_compiled
from firstcontact.device import SOURCES, Arrival, Source, SourceKind, open_source
from firstcontact.device.opening import SourceOptions, source_kind
from firstcontact.device.replay import ReplaySource
from firstcontact.device.resampled import ResampledSource
from firstcontact.device.source import drain
from firstcontact.device.twin_process import TwinOptions
from firstcontact.device.twin_source import TwinDevice
from firstcontact.recording import Header, RecordingWriter
from firstcontact.testing import check_source
from sound import local_sound

LAYOUT = fingertip_layout()
RECORDING = SOURCES["recording"]


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    path = tmp_path / "a.mcap"
    with RecordingWriter(path, Header(LAYOUT, "synthetic")) as writer:
        for first_sample, epoch in ((0, 0), (700, 0), (0, 1)):
            data = np.zeros((500, len(LAYOUT.channels)), np.int16)
            writer.write(Block(data, first_sample, epoch))
    return path


@contextmanager
def on_a_port() -> Iterator[str]:
    with TwinDevice(TwinOptions(seed=4)) as device:
        yield device.port


@contextmanager
def on_a_tape() -> Iterator[str]:
    quiet = np.random.default_rng(0).normal(0, 30, 48_000).astype(np.int16)
    with TemporaryDirectory() as folder, local_sound(Path(folder), quiet, loop=1):
        yield "audio:disc"


@contextmanager
def on_a_file() -> Iterator[str]:
    quiet = np.random.default_rng(0).normal(0, 30, 48_000 * 60).astype(np.int16)
    with TemporaryDirectory() as folder:
        wavfile.write(path := Path(folder) / "rest.wav", 48_000, quiet)
        yield f"tape:{path}"


@contextmanager
def on_a_board() -> Iterator[str]:
    with (
        TemporaryDirectory() as folder,
        PrintingBoard(Path(folder) / "port", lambda n: b"%d,%d\n" % (n, n % 9)) as board,
    ):
        yield f"csv:{board.port}"


@contextmanager
def in_a_stream() -> Iterator[str]:
    pytest.importorskip("pylsl")
    with sending(name := f"a source {uuid4().hex}"):
        yield f"lsl:{name}"


def device(name: str, recording: Path) -> AbstractContextManager[str]:
    return {
        "serial": on_a_port,
        "twin": lambda: nullcontext("twin"),
        "recording": lambda: nullcontext(str(recording)),
        "audio": on_a_tape,
        "csv": on_a_board,
        "tape": on_a_file,
        "lsl": in_a_stream,
    }[name]()


@pytest.mark.parametrize("name", SOURCES)
def test_registered_source_passes_the_conformance_check(name: str, recording: Path) -> None:
    with device(name, recording) as named:
        assert source_kind(named).name == name
        check_source(SOURCES[name], named)


@pytest.mark.parametrize("name", SOURCES)
def test_a_read_that_would_give_nothing_for_ever_is_refused(name: str, recording: Path) -> None:
    with device(name, recording) as named:
        source = SOURCES[name].make(named, SourceOptions())
        with pytest.raises(InputError):
            source.read(0.1)
        with source:
            resampled = ResampledSource(source, source.descriptor.layout.rate / 2)
            for reader in (source, resampled):
                for timeout in (math.nan, math.inf, 1e308):
                    with pytest.raises(InputError) as caught:
                        reader.read(timeout)
                    assert caught.value.parameter == "timeout"
        drain(source)
        for reader in (source, resampled):
            assert reader.ended
            with pytest.raises(InputError, match="closed"):
                reader.read(0.1)


def widened(arrival: Arrival) -> Arrival:
    data = np.pad(arrival.block.data, ((0, 0), (0, 1)))
    return replace(arrival, block=replace(arrival.block, data=data))


@pytest.mark.parametrize(
    ("name", "method"),
    [
        ("read", lambda self, t: [a for a in ReplaySource.read(self, t) for _ in range(2)]),
        ("read", lambda self, t: [widened(a) for a in ReplaySource.read(self, t)]),
        ("read", lambda self, t: ReplaySource.read(self, t)[:0]),
        ("ended", False),
        ("mark", lambda self, text: None),
    ],
    ids=["doubled", "one column too many", "no samples", "endless", "lost marker"],
)
def test_conformance_check_rejects_a_faulty_source(
    name: str, method: object, recording: Path
) -> None:
    faulty: type[ReplaySource] = type("Faulty", (ReplaySource,), {name: method})
    kind = replace(RECORDING, make=lambda path, options: faulty(Path(path), options.speed))
    with pytest.raises(AssertionError):
        check_source(kind, str(recording), SourceOptions(speed=4.0), patience=0.3)


def test_prefix_selects_a_kind_before_any_guess(monkeypatch: pytest.MonkeyPatch) -> None:
    reel = SourceKind("reel", "reel:PATH", RECORDING.make)
    greedy = SourceKind("greedy", "anything", RECORDING.make, takes=lambda device: True)
    kinds = {**SOURCES, "greedy": greedy, "reel": reel}
    monkeypatch.setattr(
        "firstcontact.device.opening.SOURCES", type(SOURCES)("source", "none", kinds)
    )
    assert source_kind("reel:a.mcap") is reel
    assert source_kind("a.mcap") is RECORDING
    assert source_kind("/dev/ttyACM0") is greedy


def test_speed_of_a_real_device_is_refused() -> None:
    with pytest.raises(InputError, match="/dev/ttyACM0") as refusal:
        open_source("/dev/ttyACM0", speed=2.0)
    assert refusal.value.parameter == "speed"


@pytest.mark.parametrize("name", ["twin", "tape", "recording"])
@pytest.mark.parametrize("speed", [0.0, -1.0, 1e-300, math.nan, -math.inf])
def test_invalid_speeds_are_refused(name: str, recording: Path, speed: float) -> None:
    with device(name, recording) as named, pytest.raises(InputError) as refusal:
        open_source(named, speed=speed)
    assert refusal.value.parameter == "speed"


def test_a_twin_without_compiled_code_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "firstcontact.twin._compiled", None)
    load_compiled.cache_clear()
    with pytest.raises(InputError, match="compiled functions"):
        open_source("twin")


def test_a_source_with_the_old_name_of_is_replay_is_refused() -> None:
    with pytest.raises(TypeError, match="rename it to is_replay"):
        type("Old", (Source,), {"recorded": True})
