"""Malicious recordings: they are refused in one sentence or noted, with little time and memory."""

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
from firstcontact.recording._chunk_file import MAGIC, ChunkFile
from firstcontact.recording._chunks import find_chunks
from firstcontact.recording._messages import block_message
from firstcontact.recording._untrusted import most_unpacked

LAYOUT = fingertip_layout()
HEADER = Header(LAYOUT, "synthetic").to_json()
MARK = PinchMark(
    0, 100, 900, 0, Label("a", 20.0), (Contact(Finger.INDEX, 300, 300),), 150
).to_json()
BLOCK = Block(np.ones((1000, 16), np.int16))


def write(path: Path, *parts: tuple[str, bytes]) -> Path:
    """Write a complete recording of these messages."""
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
    """Return a copy with one changed field."""
    copy = json.loads(json.dumps(tree))
    place = copy
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = to
    return dict(copy)


def write_recording(
    path: Path, header: Any = HEADER, mark: Any = MARK, block: Block = BLOCK
) -> Path:
    head = header if isinstance(header, bytes) else packed(header)
    samples = ("/samples", block_message(block, "int16"))
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
def test_header_out_of_bounds_is_refused(
    tmp_path: Path, header: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_recording(tmp_path / "a.mcap", header)
    assert main(["inspect", str(path)]) == 2
    message = capsys.readouterr().err
    assert message.count("\n") == 1
    assert "a.mcap: /header" in message
    assert len(message) < 1000


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
def test_mark_out_of_bounds_is_skipped(tmp_path: Path, mark: Any) -> None:
    recording = read_recording(write_recording(tmp_path / "a.mcap", mark=mark))
    assert (recording.samples, recording.pinches) == (1000, ())
    (message,) = recording.skipped
    assert message.startswith("1 pinch marks cannot be used and were left out (")
    assert len(message) < 500


def test_writer_refuses_invalid_marks(tmp_path: Path) -> None:
    with RecordingWriter(tmp_path / "a.mcap", Header(LAYOUT, "synthetic")) as writer:
        writer.write(BLOCK)
        for mark in (
            PinchMark(0, 100, 100),
            PinchMark(0, 100, 900, 0, Label("x" * 300)),
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
def read_limited() -> Callable[[Path], str]:
    """Return a function that reads a recording with 300 MiB of memory. It prints skipped parts."""

    def read(path: Path) -> str:
        command = [sys.executable, "-c", LIMITED, str(path)]
        result = subprocess.run(command, capture_output=True, text=True, check=True)
        return result.stdout

    return read


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="asks the kernel for its memory")
def test_huge_pinch_number_takes_no_memory(
    tmp_path: Path, read_limited: Callable[[Path], str]
) -> None:
    path = write_recording(tmp_path / "a.mcap", mark=changed(MARK, "number", to=10**18))
    assert f"pinches 0 to {10**18 - 1} are lost" in read_limited(path)


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="asks the kernel for its memory")
@pytest.mark.parametrize("declared", [1 << 20, 600 << 20, (1 << 64) - 1])
@pytest.mark.parametrize("kind", ["zstd", "lz4"])
def test_decompression_bomb_is_skipped(
    tmp_path: Path, read_limited: Callable[[Path], str], kind: str, declared: int
) -> None:
    """The chunk unpacks to 600 MiB of zeros. Its declared size differs from test to test."""
    zeros = bytes(1 << 20)
    if kind == "zstd":
        pack = zstandard.ZstdCompressor().compressobj()
        bomb = b"".join([*(pack.compress(zeros) for _ in range(600)), pack.flush()])
    else:
        with lz4.frame.LZ4FrameCompressor() as frame:
            parts = [frame.begin(), *(frame.compress(zeros) for _ in range(600)), frame.flush()]
        bomb = b"".join(parts)
    path = write_recording(tmp_path / "a.mcap")
    path.write_bytes(path.read_bytes() + _chunk(kind, bomb, declared, 1))
    losses = read_limited(path)
    assert "not closed" in losses
    assert ("unpack to far more" in losses) == (declared > most_unpacked(path.stat().st_size))


def _chunk(kind: str, data: bytes, size: int, crc: int) -> bytes:
    builder = RecordBuilder()
    Chunk(kind, data, 0, 0, crc, size).write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]


@pytest.mark.parametrize("kind", ["zstd", "lz4"])
def test_compressed_chunks_are_read(tmp_path: Path, kind: str) -> None:
    path = write_recording(tmp_path / "a.mcap")
    original = read_recording(path)
    data = path.read_bytes()
    out = bytearray(MAGIC)
    for start, stop in find_chunks(data):  # type: ignore[arg-type]
        inside = data[start + 9 + 40 : stop]
        pack = zstandard.compress if kind == "zstd" else lz4.frame.compress
        out += _chunk(kind, pack(inside), len(inside), zlib.crc32(inside))
    path.write_bytes(out)
    recompressed = read_recording(path)
    assert recompressed.header == original.header
    assert recompressed.pinches == original.pinches
    assert np.array_equal(recompressed.stretches[0].data, original.stretches[0].data)


def test_false_chunk_headers_are_refused_quickly(tmp_path: Path) -> None:
    """Each of 20,000 chunk headers claims the whole remaining file."""
    path = tmp_path / "a.mcap"
    entry = 9 + 40
    size = len(MAGIC) + 20_000 * entry
    out = bytearray(MAGIC)
    while len(out) < size:
        remaining = size - len(out)
        out += b"\x06" + (remaining - 9).to_bytes(8, "little") + bytes(28 + 4)
        out += (remaining - entry).to_bytes(8, "little")
    path.write_bytes(out)
    with pytest.raises(InputError, match=path.name):
        read_recording(path)


def test_unusable_samples_are_skipped(tmp_path: Path) -> None:
    far = Block(BLOCK.data, (1 << 64) - 1000)
    assert "1 messages hold no samples" in " ".join(
        read_recording(write_recording(tmp_path / "a.mcap", block=far)).skipped
    )
    nan = Block(np.full((1000, 16), np.nan, np.float32))
    path = write(
        tmp_path / "b.mcap",
        ("/header", packed(changed(HEADER, "dtype", to="float32"))),
        ("/samples", block_message(nan, "float32")),
        ("/samples", b"\0\1\0\0" + bytes(3)),
    )
    recording = read_recording(path)
    assert (recording.samples, len(recording.skipped)) == (0, 1)
    assert "2 messages hold no samples" in recording.skipped[0]


def test_overlapping_pinches_are_refused(tmp_path: Path) -> None:
    path = write(
        tmp_path / "a.mcap",
        ("/header", packed(HEADER)),
        ("/samples", block_message(BLOCK, "int16")),
        *(("/pinch", packed(changed(MARK, "number", to=k))) for k in range(100)),
    )
    with pytest.raises(InputError, match="overlap too much"):
        load_dataset(path)


def test_endless_pinch_is_dropped_alone(tmp_path: Path) -> None:
    path = write(
        tmp_path / "a.mcap",
        ("/header", packed(HEADER)),
        ("/samples", block_message(BLOCK, "int16")),
        ("/pinch", packed(MARK)),
        ("/pinch", packed({**MARK, "number": 1, "end": 1 << 53})),
    )
    dataset = load_dataset(path)
    assert len(dataset) == 1
    assert dataset.losses == ("a.mcap: pinch 1 has missing samples and is left out",)


def test_any_intact_header_is_used(tmp_path: Path) -> None:
    path = write(
        tmp_path / "a.mcap",
        ("/header", b"{"),
        ("/header", packed(changed(HEADER, "source", to="martian"))),
        ("/header", packed(HEADER)),
        ("/samples", block_message(BLOCK, "int16")),
    )
    assert read_recording(path).header == Header(LAYOUT, "synthetic")
