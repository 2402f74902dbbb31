"""The chain gives equal events in Python, as a program of this machine and on a Cortex-M7."""

from collections import Counter
from collections.abc import Callable
from pathlib import Path

import building
import numpy as np
import pytest
from firmware_build import need_arm

from firstcontact.chain import EventKind, Image
from firstcontact.chain.constants import DetectorKind
from random_chains import MODELS, Stream, python_events, random_image, random_stream

FIELDS = [name for name in building.EVENT.names or () if name not in ("instructions", "waited")]
KINDS = (DetectorKind.LOGISTIC, DetectorKind.THRESHOLD)
#: Streams with one random model.
MOST = 500
#: Events that streams must contain for the comparison to mean anything.
NEEDED = {
    EventKind.CLOSING_BEGAN, EventKind.CONTACT_FOUND, EventKind.CONTACT_WITHDRAWN,
    EventKind.ESTIMATED, EventKind.NOT_ESTIMATED, EventKind.CLOSING_ENDED,
}  # fmt: skip
Ask = Callable[[Path, bytes, Path], bytes]


@pytest.fixture(scope="module")
def program() -> building.Program:
    """Return the program that runs the chain's own C files over streams."""
    return building.chain_program("streams.c", Path("no-further-sources"))


def assert_same_events(
    image: Image, streams: list[Stream], binary: Path, ask: Ask, folder: Path
) -> Counter[int]:
    """Assert equal bits of all events. Return the number of events of each kind."""
    data = [
        building.Stream(s.pieces, s.floors if s.has_floors else None, s.alpha, s.hints)
        for s in streams
    ]
    got = building.events(ask(binary, building.streams(image.data, data), folder))
    counts: Counter[int] = Counter()
    for stream, records in zip(streams, got, strict=True):
        events = python_events(image, stream)
        ours, theirs = np.zeros((2, len(events)), building.EVENT)
        for name, column in zip(FIELDS, zip(*events, strict=True), strict=False):
            ours[name] = column
            theirs[name] = records[:-1][name]
        assert ours.tobytes() == theirs.tobytes()
        counts.update(ours["kind"].tolist())
    return counts


def assert_random_streams_agree(n: int, binary: Path, ask: Ask, folder: Path, least: int) -> None:
    counts: Counter[int] = Counter()
    size = min(MOST, n // len(MODELS))
    for k, seed in enumerate(range(0, n, size)):
        rng = np.random.default_rng(seed)
        image = random_image(seed, KINDS[k % len(KINDS)], list(MODELS)[k % len(MODELS)])
        streams = [random_stream(rng) for _ in range(min(size, n - seed))]
        counts += assert_same_events(image, streams, binary, ask, folder)
    assert all(counts[kind] >= least for kind in NEEDED), counts


def test_native_program_gives_the_events_of_python(
    program: building.Program, tmp_path: Path
) -> None:
    binary = program.native(tmp_path / "streams")
    assert_random_streams_agree(4_000, binary, building.ask_native, tmp_path, 40)


@pytest.mark.slow
def test_native_program_gives_the_events_of_python_in_many_streams(
    program: building.Program, tmp_path: Path
) -> None:
    binary = program.native(tmp_path / "streams")
    assert_random_streams_agree(100_000, binary, building.ask_native, tmp_path, 1000)


def test_native_program_has_no_undefined_behaviour(
    program: building.Program, tmp_path: Path
) -> None:
    binary = program.native(tmp_path / "streams", strict=True)
    assert_random_streams_agree(600, binary, building.ask_native, tmp_path, 1)


def test_cortex_m7_gives_the_events_of_python(
    program: building.Program, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    need_arm(request, "arm-none-eabi-gcc", "qemu-system-arm")
    binary = program.m7(tmp_path / "streams.elf")
    assert_random_streams_agree(300, binary, building.ask_m7, tmp_path, 1)
