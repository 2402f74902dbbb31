import io
import os
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from firstcontact.core import Block, Contact, Finger, InputError, Label, Pinch, fingertip_layout
from firstcontact.recording import Header, Marker, PinchMark, RecordingWriter, read_recording
from firstcontact.recording._mcap import McapWriter
from firstcontact.recording.messages import LONGEST_TEXT
from processes import full_disk

# Writes blocks of 37 samples as fast as it can and says after each what it handed over.
WRITER = """
import os, sys
from pathlib import Path
import numpy as np
from firstcontact.core import Block, fingertip_layout
from firstcontact.recording import Header, RecordingWriter
with RecordingWriter(Path(sys.argv[1]), Header(fingertip_layout(), "synthetic")) as writer:
    first = 0
    while True:
        number = np.arange(first, first + 37, dtype=np.int64)
        data = np.zeros((37, 16), np.int16)
        data[:, 0], data[:, 1] = number & 0x7FFF, number >> 15
        writer.write(Block(data, first))
        first += 37
        os.write(1, b"%d\\n" % first)
"""


MESSAGES = st.lists(st.tuples(st.integers(1, 3), st.integers(0, 1 << 63), st.binary(max_size=90)))


@given(MESSAGES, st.sampled_from((50, 200, 5000)))
def test_file_is_that_of_the_library(messages, size):
    theirs, ours = io.BytesIO(), io.BytesIO()
    library = Writer(theirs, size, compression=CompressionType.NONE)
    library.start("ros2", "firstcontact")
    writer = McapWriter(ours, size)
    for name in ("/a", "/ü", "/c"):
        schema = library.register_schema(name, "jsonschema", b"{}")
        library.register_channel(name, "json", schema)
        writer.add_channel(name, "json", writer.add_schema(name, "jsonschema", b"{}"))
    for number, (channel, time, data) in enumerate(messages):
        library.add_message(channel, time, data, time, number)
        writer.add_message(channel, time, data, number)
        if number % 7 == 3:
            library.flush()
            writer.flush()
    library.finish()
    writer.finish()
    assert ours.getvalue() == theirs.getvalue()


def test_recording_round_trips(tmp_path, layout, counted):
    path = tmp_path / "Übung äöü 指.mcap"
    header = Header(layout, "real", "int16", "s", "h", "1.0", "Tag 1", "naß", "2024-01-01T00:00:00")
    mark = PinchMark(
        0, 10, 90, 0, Label("Apfel", 28.0, None, "a1"), (Contact(Finger.THUMB, 20, 20),)
    )
    with RecordingWriter(path, header) as writer:
        writer.write(counted(0, 500))
        writer.mark(mark)
        writer.marker(Marker(400, "Kabel berührt"))
    recording = read_recording(path)
    assert recording.header == header
    assert recording.pinches == (mark,)
    assert recording.markers == (Marker(400, "Kabel berührt"),)
    assert recording.skipped == ()
    (stretch,) = recording.stretches
    assert np.array_equal(stretch.data, counted(0, 500).data)
    assert recording.duration == 500 / layout.rate


@pytest.mark.parametrize("dtype", ["int16", "int32", "float32"])
def test_samples_keep_their_type(tmp_path, layout, dtype):
    data = np.array([[-3, 2], [7, 5]], dtype)
    with RecordingWriter(tmp_path / "a.mcap", Header(layout, dtype=dtype)) as writer:
        writer.write(Block(data))
    (stretch,) = read_recording(tmp_path / "a.mcap").stretches
    assert stretch.data.dtype == data.dtype
    assert np.array_equal(stretch.data, data)


def test_the_same_samples_give_the_same_bytes(tmp_path, layout, counted):
    for name in ("a.mcap", "b.mcap"):
        with RecordingWriter(tmp_path / name, Header(layout)) as writer:
            writer.write(counted(0, 900))
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


def test_other_mcap_readers_see_increasing_times(tmp_path, layout, counted):
    path = tmp_path / "a.mcap"
    with RecordingWriter(path, Header(layout)) as writer:
        writer.write(counted(1000, 450))
        writer.write(counted(0, 300, epoch=1))  # the device was reset: it counts from 0 again
        writer.write(counted(50_00, 10, epoch=2))
    with path.open("rb") as stream:
        messages = [m for _, c, m in make_reader(stream).iter_messages(log_time_order=False)]
    times = [m.log_time for m in messages]
    assert times == sorted(times)
    assert [m.sequence for m in messages] == list(range(len(messages)))
    assert [s.epoch for s in read_recording(path).stretches] == [0, 1, 2]


def test_index_contains_every_message(small):
    with small.open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        sequence_numbers = [m.sequence for _, _, m in reader.iter_messages()]
    assert len(summary.chunk_indexes) == summary.statistics.chunk_count
    assert sorted(sequence_numbers) == list(range(summary.statistics.message_count))


def test_separate_pinches_are_epochs(tmp_path, layout, counted):
    def pinch(first):
        return Pinch(counted(first, 100).data, layout, first_sample=first)

    with RecordingWriter(tmp_path / "a.mcap", Header(layout)) as writer:
        for first in (0, 100, 300):
            writer.pinch(pinch(first))
    recording = read_recording(tmp_path / "a.mcap")
    assert [(p.number, p.first_sample, p.epoch) for p in recording.pinches] == [
        (0, 0, 0),
        (1, 100, 0),
        (2, 300, 1),
    ]
    assert recording.skipped == ()


def test_a_recording_is_never_overwritten(small, layout):
    content = small.read_bytes()
    with pytest.raises(InputError, match=small.name):
        RecordingWriter(small, Header(layout))
    assert small.read_bytes() == content


def test_blocks_that_do_not_fit_the_header_are_refused(tmp_path, layout, counted):
    with RecordingWriter(tmp_path / "a.mcap", Header(layout)) as writer:
        with pytest.raises(InputError, match="2 columns"):
            writer.write(Block(np.zeros((5, 3), np.int16)))
        with pytest.raises(InputError, match="dtype"):
            writer.write(Block(np.zeros((5, 2))))
    with pytest.raises(InputError, match=r"\.mcap"):
        writer.write(counted(0, 5))


def test_exception_finalises_the_file(tmp_path, layout, counted):
    path = tmp_path / "a.mcap"

    def interrupted():
        with RecordingWriter(path, Header(layout)) as writer:
            writer.write(counted(0, 33))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    recording = read_recording(path)
    assert (recording.samples, recording.skipped) == (33, ())


@pytest.mark.parametrize("acknowledged", [1, 2, 40, 333, 1500, 5000])
def test_a_killed_writer_loses_at_most_a_tenth_of_a_second(tmp_path, acknowledged):
    path = tmp_path / "killed.mcap"
    command = [sys.executable, "-c", WRITER, str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as child:
        for _ in range(acknowledged):
            handed = int(child.stdout.readline())
        os.kill(child.pid, signal.SIGKILL)
        handed = max([handed, *map(int, child.stdout.read().splitlines()[:-1])])
    recording = read_recording(path)
    assert any("not closed" in s for s in recording.skipped)
    if recording.stretches:
        (stretch,) = recording.stretches  # one: nothing is missing in the middle
        number = np.arange(len(stretch.data), dtype=np.int64)
        assert stretch.first_sample == 0
        assert np.array_equal(stretch.data[:, 0], number & 0x7FFF)
        assert np.array_equal(stretch.data[:, 1], number >> 15)
    assert recording.samples >= handed - 0.1 * fingertip_layout().rate


def test_full_disk_stops_the_writer_and_keeps_complete_chunks(tmp_path, layout, counted):
    limit = 40_000
    path = tmp_path / "full.mcap"
    writer = RecordingWriter(path, Header(layout))
    sample_count = 0

    def fill():
        nonlocal sample_count
        while True:
            writer.write(counted(sample_count, 64))
            sample_count += 64

    with full_disk(limit):
        with pytest.raises(InputError, match=path.name):
            fill()
        with pytest.raises(InputError, match=r"\.mcap"):
            writer.write(counted(sample_count, 64))
        writer.close()
    assert path.stat().st_size == limit
    (stretch,) = read_recording(path).stretches
    assert stretch.end >= sample_count - 0.1 * layout.rate
    assert np.array_equal(stretch.data, counted(0, stretch.end).data)


def test_recording_at_the_highest_rate_is_read(tmp_path):
    """The padding after the first header is longer than the longest JSON."""
    path = tmp_path / "a.mcap"
    header = Header(replace(fingertip_layout(), rate=1e7), "synthetic", "float32")
    with RecordingWriter(path, header) as writer:
        writer.write(Block(np.ones((1000, 16), np.float32)))
    recording = read_recording(path)
    assert (recording.header, recording.samples, recording.skipped) == (header, 1000, ())


def test_invalid_header_leaves_no_file(tmp_path, layout):
    path = tmp_path / "a.mcap"
    # A name that is not UTF-8, as arguments can be, and a long one.
    for header in (Header(layout, sensor="\udcff"), Header(layout, sensor="x" * 300)):
        with pytest.raises(InputError, match="the header"):
            RecordingWriter(path, header)
        assert not path.exists()


def test_invalid_marker_text_does_not_end_a_recording(tmp_path, layout):
    path = tmp_path / "a.mcap"
    with RecordingWriter(path, Header(layout)) as writer:
        writer.marker(Marker(3, "half \udcff"))
        writer.marker(Marker(4, "x" * (LONGEST_TEXT + 1)))
    recording = read_recording(path)
    half, long = recording.markers
    assert half.text == "half ?"
    assert long.text == "x" * (LONGEST_TEXT - 1) + "…"
    assert recording.skipped == ()
