"""Recordings that were made to do harm: one sentence or a note, in little time and memory."""

from __future__ import annotations

import json
import subprocess
import sys
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import lz4.frame
import numpy as np
import pytest
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.records import Chunk

from firstcontact.cli.main import main
from firstcontact.core import Block, Contact, Finger, InputError, Label, fingertip_layout
from firstcontact.recording import Header, PinchMark, RecordingWriter, load_dataset, read_recording
from firstcontact.recording import _samples as messages
from firstcontact.recording._chunk_file import MAGIC, ChunkFile
from firstcontact.recording._chunks import _candidates
from firstcontact.recording._sizes import most_unpacked

LAYOUT = fingertip_layout()
HEADER = Header(LAYOUT, "synthetic").to_json()
MARK = PinchMark(
    0, 100, 900, 0, Label("a", 20.0), (Contact(Finger.INDEX, 300, 300),), 150
).to_json()
BLOCK = Block(np.ones((1000, 16), np.int16))


def write(path: Path, *parts: tuple[str, bytes]) -> Path:
    """A whole recording of these messages."""
    with path.open("w+b") as stream:
        file = ChunkFile(stream, 100, "ros2", "test")
        topics = ("/header", "/samples", "/pinch", "/marker")
        numbers = {t: file.register(t, "json", (t, "jsonschema", b"{}")) for t in topics}
        for place, (topic, data) in enumerate(parts):
            file.add(numbers[topic], 0, data, place)
        file.finish()
    return path


def packed(tree: Any) -> bytes:
    return json.dumps(tree).encode()


def changed(tree: dict[str, Any], *path: str | int, to: Any) -> dict[str, Any]:
    """A copy with one field that is something else."""
    copy = json.loads(json.dumps(tree))
    place = copy
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = to
    return dict(copy)


def whole(path: Path, header: Any = HEADER, mark: Any = MARK, block: Block = BLOCK) -> Path:
    head = header if isinstance(header, bytes) else packed(header)
    samples = ("/samples", messages.encode(block, "int16"))
    return write(path, ("/header", head), samples, ("/pinch", packed(mark)))


channel = ("layout", "channels", 0)
calibration = {"piezo": [], "force": [], "created": ""}


@pytest.mark.parametrize(
    "header",
    [
        changed(HEADER, "layout", to=[]),
        changed(HEADER, "layout", "channels", to=[]),
        changed(HEADER, "layout", "channels", to=HEADER["layout"]["channels"] * 20),
        changed(HEADER, "layout", "channels", to=HEADER["layout"]["channels"][:1] * 2),
        changed(HEADER, "layout", "rate", to=0),
        changed(HEADER, "layout", "rate", to=-4936.0),
        changed(HEADER, "layout", "rate", to=1e300),
        changed(HEADER, "layout", "rate", to="fast"),
        changed(HEADER, "layout", "rate", to=10**400),
        changed(HEADER, "layout", "smoothing_alpha", to=0),
        changed(HEADER, *channel, "scale", to=0),
        changed(HEADER, *channel, "scale", to=1e-300),
        changed(HEADER, *channel, "scale", to=1e300),
        changed(HEADER, *channel, "offset", to=1e300),
        changed(HEADER, *channel, "finger", to=7),
        changed(HEADER, *channel, "taxel", to=10**9),
        changed(HEADER, *channel, "kind", to="smell"),
        changed(HEADER, *channel, "name", to="x" * 100_000),
        changed(HEADER, "session", to=None),
        changed(HEADER, "source", to="martian"),
        changed(HEADER, "dtype", to="object"),
        changed(HEADER, "notes", to="x" * 200_000),
        {**HEADER, "calibration": 3},
        {**HEADER, "calibration": {**calibration, "piezo": [{"finger": 0, "noise": -1}]}},
        {**HEADER, "calibration": {**calibration, "force": [{}] * 1000}},
        packed(HEADER).replace(b"4936.0", b"1e999"),
        packed(HEADER).replace(b"4936.0", b"NaN"),
        packed(HEADER)[:-1] + b', "more": ' + b"[" * 5_000_000,
        b'{"a":' * 1_000_000,
        b"\xff",
        b"null",
    ],
)
def test_a_header_out_of_bounds_is_one_sentence(
    tmp_path: Path, header: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    path = whole(tmp_path / "a.mcap", header)
    assert main(["inspect", str(path)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "a.mcap: /header" in said
    assert len(said) < 1000


@pytest.mark.parametrize(
    "mark",
    [
        changed(MARK, "number", to=-1),
        changed(MARK, "number", to=1.5),
        changed(MARK, "number", to=10**30),
        changed(MARK, "end", to=50),
        changed(MARK, "end", to=10**18),
        changed(MARK, "first_sample", to="0"),
        changed(MARK, "epoch", to=2**40),
        changed(MARK, "label", to=None),
        changed(MARK, "label", "shore_a", to=1e6),
        changed(MARK, "label", "hardness_rank", to=10**12),
        changed(MARK, "label", "role", to="judge"),
        changed(MARK, "label", "object", to="x" * 100_000),
        changed(MARK, "truth", 0, "finger", to=2),
        changed(MARK, "truth", 0, "sample", to=950),
        changed(MARK, "truth", to=MARK["truth"] * 2),
        changed(MARK, "truth", to=MARK["truth"] * 1000),
        changed(MARK, "motor_start", to=3),
        [],
        3,
        None,
    ],
)
def test_a_mark_out_of_bounds_is_left_out_and_told(tmp_path: Path, mark: Any) -> None:
    recording = read_recording(whole(tmp_path / "a.mcap", mark=mark))
    assert (recording.samples, recording.pinches) == (1000, ())
    (said,) = recording.skipped
    assert said.startswith("1 pinch marks cannot be used and were left out (")
    assert len(said) < 500


def test_marks_that_would_be_refused_are_not_written(tmp_path: Path) -> None:
    with RecordingWriter(tmp_path / "a.mcap", Header(LAYOUT, "synthetic")) as writer:
        writer.write(BLOCK)
        for mark in (
            PinchMark(0, 100, 100),
            PinchMark(0, 100, 900, 0, Label("x" * 300)),
            PinchMark(0, 100, 900, 0, Label("x", float("nan"))),
        ):
            with pytest.raises(InputError, match="the mark of pinch 0"):
                writer.mark(mark)
        with pytest.raises(InputError, match="sample number"):
            writer.write(Block(BLOCK.data, 1 << 60))
    recording = read_recording(tmp_path / "a.mcap")
    assert (recording.samples, recording.pinches, recording.skipped) == (1000, (), ())


# Memory of the child: what the program takes by itself, and far less than a bomb would.
LIMITED = """
import resource, sys
from pathlib import Path
from firstcontact.recording import read_recording
import numpy, mcap, zstandard, lz4.frame
free = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (free + (300 << 20),) * 2)
print(*read_recording(Path(sys.argv[1])).skipped, sep="\\n")
"""


@pytest.fixture
def told() -> Callable[[Path], str]:
    """Read a recording with 300 MiB, and what was skipped."""

    def read(path: Path) -> str:
        command = [sys.executable, "-c", LIMITED, str(path)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        return done.stdout

    return read


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="asks the kernel for its memory")
def test_a_number_far_off_costs_nothing(tmp_path: Path, told: Callable[[Path], str]) -> None:
    path = whole(tmp_path / "a.mcap", mark=changed(MARK, "number", to=10**18))
    assert f"pinches 0 to {10**18 - 1} are lost" in told(path)


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="asks the kernel for its memory")
@pytest.mark.parametrize("declared", [1 << 20, 600 << 20, (1 << 64) - 1])
@pytest.mark.parametrize("kind", ["zstd", "lz4"])
def test_a_chunk_that_unpacks_to_far_too_much_is_skipped(
    tmp_path: Path, told: Callable[[Path], str], kind: str, declared: int
) -> None:
    """600 MiB of nothing, whatever the chunk says of it."""
    zeros = bytes(1 << 20)
    if kind == "zstd":
        pack = zstandard.ZstdCompressor().compressobj()
        bomb = b"".join([*(pack.compress(zeros) for _ in range(600)), pack.flush()])
    else:
        with lz4.frame.LZ4FrameCompressor() as frame:
            parts = [frame.begin(), *(frame.compress(zeros) for _ in range(600)), frame.flush()]
        bomb = b"".join(parts)
    path = whole(tmp_path / "a.mcap")
    path.write_bytes(path.read_bytes() + _chunk(kind, bomb, declared, 1))
    said = told(path)
    assert "not closed" in said
    assert ("unpack to far more" in said) == (declared > most_unpacked(path.stat().st_size))


def _chunk(kind: str, data: bytes, size: int, crc: int) -> bytes:
    builder = RecordBuilder()
    Chunk(kind, data, 0, 0, crc, size).write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]


@pytest.mark.parametrize("kind", ["zstd", "lz4"])
def test_honest_compression_is_read(tmp_path: Path, kind: str) -> None:
    path = whole(tmp_path / "a.mcap")
    plain = read_recording(path)
    data = path.read_bytes()
    out = bytearray(MAGIC)
    for start, stop in _candidates(data):  # type: ignore[arg-type]
        inside = data[start + 9 + 40 : stop]
        pack = zstandard.compress if kind == "zstd" else lz4.frame.compress
        out += _chunk(kind, pack(inside), len(inside), zlib.crc32(inside))
    path.write_bytes(out)
    packed_again = read_recording(path)
    assert packed_again.header == plain.header
    assert packed_again.pinches == plain.pinches
    assert np.array_equal(packed_again.stretches[0].data, plain.stretches[0].data)


def test_what_looks_like_chunks_and_is_none_ends_soon(tmp_path: Path) -> None:
    """Each of 20,000 beginnings of a chunk claims the rest of the file."""
    path = tmp_path / "a.mcap"
    entry = 9 + 40
    size = len(MAGIC) + 20_000 * entry
    out = bytearray(MAGIC)
    while len(out) < size:
        left = size - len(out)
        out += b"\x06" + (left - 9).to_bytes(8, "little") + bytes(28 + 4)
        out += (left - entry).to_bytes(8, "little")
    path.write_bytes(out)
    with pytest.raises(InputError, match=path.name):
        read_recording(path)


def test_samples_that_nobody_can_count_or_compute_with_are_left_out(tmp_path: Path) -> None:
    far = Block(BLOCK.data, (1 << 64) - 1000)
    assert "1 messages hold no samples" in " ".join(
        read_recording(whole(tmp_path / "a.mcap", block=far)).skipped
    )
    nan = Block(np.full((1000, 16), np.nan, np.float32))
    path = write(
        tmp_path / "b.mcap",
        ("/header", packed(changed(HEADER, "dtype", to="float32"))),
        ("/samples", messages.encode(nan, "float32")),
        ("/samples", b"\0\1\0\0" + bytes(3)),
    )
    recording = read_recording(path)
    assert (recording.samples, len(recording.skipped)) == (0, 1)
    assert "2 messages hold no samples" in recording.skipped[0]


def test_pinches_on_top_of_each_other_are_left_out(tmp_path: Path) -> None:
    path = write(
        tmp_path / "a.mcap",
        ("/header", packed(HEADER)),
        ("/samples", messages.encode(BLOCK, "int16")),
        *(("/pinch", packed(changed(MARK, "number", to=k))) for k in range(100)),
    )
    with pytest.raises(InputError, match="on top of each other"):
        load_dataset(path)


def test_a_pinch_that_never_ends_costs_no_other(tmp_path: Path) -> None:
    path = write(
        tmp_path / "a.mcap",
        ("/header", packed(HEADER)),
        ("/samples", messages.encode(BLOCK, "int16")),
        ("/pinch", packed(MARK)),
        ("/pinch", packed({**MARK, "number": 1, "end": 1 << 53})),
    )
    dataset = load_dataset(path)
    assert len(dataset) == 1
    assert dataset.losses == ("a.mcap: pinch 1 lies across missing samples and is left out",)


def test_any_intact_header_will_do(tmp_path: Path) -> None:
    path = write(
        tmp_path / "a.mcap",
        ("/header", b"{"),
        ("/header", packed(changed(HEADER, "source", to="martian"))),
        ("/header", packed(HEADER)),
        ("/samples", messages.encode(BLOCK, "int16")),
    )
    assert read_recording(path).header == Header(LAYOUT, "synthetic")
