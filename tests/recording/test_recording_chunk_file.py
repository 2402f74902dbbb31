"""The chunk writer writes the same bytes as the MCAP library, with constant memory."""

import io
import resource
import tempfile
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from firstcontact.core import Block, fingertip_layout
from firstcontact.recording import Header, RecordingWriter, read_recording
from firstcontact.recording._chunk_file import ChunkFile
from firstcontact.recording._chunks import read_chunks

JSON = ("a.Thing", "jsonschema", b'{"type": "object"}')
OTHER = ("b.Thing", "ros2msg", b"uint8 x\n")
HOUR = 3600


@given(
    st.lists(st.tuples(st.integers(1, 2), st.integers(0, 10**12), st.binary(max_size=40))),
    st.integers(0, 300),
)
def test_bytes_equal_those_of_the_mcap_library(messages, chunk_size):
    expected = io.BytesIO()
    theirs = Writer(expected, chunk_size=chunk_size, compression=CompressionType.NONE)
    theirs.start(profile="ros2", library="us")
    for topic, (name, encoding, text) in (("/a", JSON), ("/b", OTHER)):
        theirs.register_channel(topic, "json", theirs.register_schema(name, encoding, text))
    for k, (channel, time, data) in enumerate(messages):
        theirs.add_message(channel, time, data, time, k)
    theirs.finish()
    with tempfile.TemporaryFile() as stream:
        ours = ChunkFile(stream, chunk_size, "ros2", "us")
        for topic, schema in (("/a", JSON), ("/b", OTHER)):
            ours.register(topic, "json", schema)
        for k, (channel, time, data) in enumerate(messages):
            ours.add(channel, time, data, k)
        ours.finish()
        stream.seek(0)
        assert stream.read() == expected.getvalue()


def test_index_contains_every_message(small):
    with small.open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        sequence_numbers = [m.sequence for _, _, m in reader.iter_messages()]
    assert summary is not None
    assert len(summary.chunk_indexes) == summary.statistics.chunk_count
    assert sorted(sequence_numbers) == list(range(summary.statistics.message_count))


def count_up(first: int, samples: int) -> Block:
    """Return a block whose first two columns encode the sample number."""
    number = np.arange(first, first + samples, dtype=np.int64)
    data = np.zeros((samples, 16), np.int16)
    data[:, 0], data[:, 1] = number & 0x7FFF, number >> 15
    return Block(data, first)


def write_seconds(writer: RecordingWriter, first: int, seconds: int) -> int:
    """Write blocks of 5 ms for this long. Return the next sample number."""
    end = first + round(seconds * fingertip_layout().rate)
    for start in range(first, end, 25):
        writer.write(count_up(start, min(25, end - start)))
    return end


def test_writer_memory_is_constant(tmp_path):
    with RecordingWriter(tmp_path / "a.mcap", Header(fingertip_layout(), "synthetic")) as writer:
        end = write_seconds(writer, 0, 10)
        tracemalloc.start()
        try:
            memory_before, _ = tracemalloc.get_traced_memory()
            end = write_seconds(writer, end, 20)
            memory_after, _ = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
    # A chunk that waits is 8 kB; an index entry for each of 400 chunks would be 200 kB.
    assert memory_after - memory_before < 50_000
    (stretch,) = read_recording(tmp_path / "a.mcap").stretches
    assert stretch.end == end


@pytest.mark.slow
def test_an_hour_has_no_losses_and_constant_memory(tmp_path):
    path = tmp_path / "hour.mcap"
    with RecordingWriter(path, Header(fingertip_layout(), "synthetic")) as writer:
        end = write_seconds(writer, 0, 60)
        memory_before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        end = write_seconds(writer, end, HOUR - 60)
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - memory_before
    assert grown < 4_000, f"{grown} kB more at the end of the hour than after its first minute"
    recording = read_recording(path)
    (stretch,) = recording.stretches
    number = np.arange(end, dtype=np.int64)
    assert recording.skipped == ()
    assert np.array_equal(stretch.data[:, 0], (number & 0x7FFF).astype(np.int16))
    assert np.array_equal(stretch.data[:, 1], (number >> 15).astype(np.int16))


@pytest.mark.slow
def test_more_than_two_gigabytes_are_indexed_and_read(tmp_path: Path):
    path = tmp_path / "large.mcap"
    # Wide samples: the file grows fast, and its offsets need more than 32 bits.
    block = np.zeros((24_000, 16), np.float32)
    seconds = 2**32 // (24_000 * 64) + 2
    with RecordingWriter(path, Header(fingertip_layout(), "synthetic", "float32")) as writer:
        for k in range(seconds):
            block[:, 0] = k
            writer.write(Block(block, k * len(block)))
    assert path.stat().st_size > 2**32
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert max(c.chunk_start_offset for c in summary.chunk_indexes) > 2**32
    assert read_chunks(path)[1] == []
