"""Malicious recordings: they are refused in one sentence or noted, with little time and memory."""

import json
import tracemalloc
import zlib

import lz4.frame
import numpy as np
import pytest
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.records import Chunk
from mcap.writer import CompressionType, Writer

from firstcontact.core import Block, Contact, Finger, InputError, Label, fingertip_layout
from firstcontact.recording import Header, PinchMark, RecordingWriter, load_dataset, read_recording
from firstcontact.recording._chunks import MAGIC, find_chunks
from firstcontact.recording.messages import block_message

LAYOUT = fingertip_layout()
HEADER = Header(LAYOUT, "synthetic").to_json()
MARK = PinchMark(
    0, 100, 900, 0, Label("a", 20.0), (Contact(Finger.INDEX, 300, 300),), 150
).to_json()
BLOCK = Block(np.ones((1000, 16), np.int16))


def write(path, *parts):
    """Write a complete recording of these messages."""
    with path.open("wb") as stream:
        file = Writer(stream, 100, compression=CompressionType.NONE)
        file.start("ros2", "test")
        topics = ("/header", "/samples", "/pinch", "/marker")
        schemas = {topic: file.register_schema(topic, "jsonschema", b"{}") for topic in topics}
        numbers = {t: file.register_channel(t, "json", number) for t, number in schemas.items()}
        for place, (topic, data) in enumerate(parts):
            file.add_message(numbers[topic], 0, data, 0, place)
        file.finish()
    return path


def packed(tree):
    return json.dumps(tree).encode()


def changed(tree, *path, to):
    """Return a copy with one changed field."""
    copy = json.loads(json.dumps(tree))
    place = copy
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = to
    return dict(copy)


def write_recording(path, header=HEADER, mark=MARK, block=BLOCK):
    head = header if isinstance(header, bytes) else packed(header)
    samples = ("/samples", block_message(block, "int16"))
    return write(path, ("/header", head), samples, ("/pinch", packed(mark)))


CHANNEL = ("layout", "channels", 0)


@pytest.mark.parametrize(
    "header",
    [
        changed(HEADER, "layout", "channels", to=[]),
        changed(HEADER, "layout", "channels", to=HEADER["layout"]["channels"] * 20),
        changed(HEADER, "layout", "rate", to=-4936.0),
        changed(HEADER, *CHANNEL, "scale", to=0),
        changed(HEADER, *CHANNEL, "finger", to=7),
        changed(HEADER, "source", to="martian"),
        changed(HEADER, "notes", to="x" * 200_000),
        {**HEADER, "calibration": {"piezo": [], "force": [{}] * 1000, "created": ""}},
        packed(HEADER).replace(b"4936.0", b"NaN"),
        packed(HEADER)[:-1] + b', "more": ' + b"[" * 5_000_000,
        {"format": "firstcontact.recording", "version": 3},
        {"format": "firstcontact.recording", "version": 2},
        {"format": "other"},
        b"\xff",
        b"null",
    ],
    ids=range(15),
)
def test_header_out_of_bounds_is_refused(tmp_path, header):
    path = write_recording(tmp_path / "a.mcap", header)
    with pytest.raises(InputError, match=r"a\.mcap: /header") as error:
        read_recording(path)
    assert len(str(error.value)) < 1000


@pytest.mark.parametrize(
    "mark",
    [
        changed(MARK, "number", to=10**30),
        changed(MARK, "end", to=50),
        changed(MARK, "label", "shore_a", to=1e6),
        changed(MARK, "label", "object", to="x" * 100_000),
        changed(MARK, "truth", 0, "sample", to=950),
        changed(MARK, "truth", to=MARK["truth"] * 1000),
        changed(MARK, "motor_start", to=3),
        [],
    ],
    ids=range(8),
)
def test_mark_out_of_bounds_is_skipped(tmp_path, mark):
    recording = read_recording(write_recording(tmp_path / "a.mcap", mark=mark))
    assert (recording.samples, recording.pinches) == (1000, ())
    (message,) = recording.skipped
    assert message.startswith("1 pinch marks cannot be used and were left out (")
    assert len(message) < 500


def test_writer_refuses_invalid_marks(tmp_path):
    with RecordingWriter(tmp_path / "a.mcap", Header(LAYOUT, "synthetic")) as writer:
        writer.write(BLOCK)
        with pytest.raises(InputError, match="the mark of pinch 0"):
            writer.mark(PinchMark(0, 100, 900, 0, found_by="x" * 300))
        with pytest.raises(InputError, match="sample number"):
            writer.write(Block(BLOCK.data, 1 << 60))
    recording = read_recording(tmp_path / "a.mcap")
    assert (recording.samples, recording.pinches, recording.skipped) == (1000, (), ())


@pytest.fixture
def check_memory():
    """Assert that a test allocates far less memory than a bomb would."""
    tracemalloc.start()
    try:
        yield
        assert tracemalloc.get_traced_memory()[1] < 300 << 20
    finally:
        tracemalloc.stop()


@pytest.fixture(scope="module")
def bombs():
    """Return compressed chunks that unpack to 600 MiB of zeros."""
    zeros = bytes(1 << 20)
    pack = zstandard.ZstdCompressor().compressobj()
    with lz4.frame.LZ4FrameCompressor() as frame:
        parts = [frame.begin(), *(frame.compress(zeros) for _ in range(600)), frame.flush()]
    zstd = [*(pack.compress(zeros) for _ in range(600)), pack.flush()]
    return {"zstd": b"".join(zstd), "lz4": b"".join(parts)}


@pytest.mark.usefixtures("check_memory")
@pytest.mark.parametrize("declared", [1 << 20, 600 << 20, (1 << 64) - 1])
@pytest.mark.parametrize("kind", ["zstd", "lz4"])
def test_decompression_bomb_is_skipped(tmp_path, bombs, kind, declared):
    path = write_recording(tmp_path / "a.mcap")
    path.write_bytes(path.read_bytes() + _chunk(kind, bombs[kind], declared, 1))
    assert "not closed" in " ".join(read_recording(path).skipped)


def _chunk(kind, data, size, crc):
    builder = RecordBuilder()
    Chunk(kind, data, 0, 0, crc, size).write(builder)
    return bytes(builder.end())


@pytest.mark.parametrize("kind", ["zstd", "lz4"])
def test_compressed_chunks_are_read(tmp_path, kind, monkeypatch):
    path = write_recording(tmp_path / "a.mcap")
    original = read_recording(path)
    samples = original.stretches[0].data
    data = path.read_bytes()
    out = bytearray(MAGIC)
    for start, stop in find_chunks(data):
        inside = data[start + 9 + 40 : stop]
        pack = zstandard.compress if kind == "zstd" else lz4.frame.compress
        out += _chunk(kind, pack(inside), len(inside), zlib.crc32(inside))
    path.write_bytes(out)
    with monkeypatch.context() as without:
        without.setattr("firstcontact.core.installation.find_spec", lambda name: None)
        with pytest.raises(InputError, match=kind if kind == "lz4" else "zstandard"):
            read_recording(path)
    recompressed = read_recording(path)
    assert recompressed.header == original.header
    assert recompressed.pinches == original.pinches
    assert np.array_equal(recompressed.stretches[0].data, samples)


def test_false_chunk_headers_are_refused_quickly(tmp_path):
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


def test_unusable_samples_are_skipped(tmp_path):
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


def test_endless_pinch_is_dropped_alone(tmp_path):
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


def test_any_intact_header_is_used(tmp_path):
    path = write(
        tmp_path / "a.mcap",
        ("/header", b"{"),
        ("/header", packed(changed(HEADER, "source", to="martian"))),
        ("/header", packed(HEADER)),
        ("/samples", block_message(BLOCK, "int16")),
    )
    assert read_recording(path).header == Header(LAYOUT, "synthetic")
