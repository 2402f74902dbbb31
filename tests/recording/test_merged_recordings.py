"""Recordings that other programs rewrite are read, and those that they merge are never mixed."""

from io import BytesIO

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from firstcontact.core import Block, Channel, ChannelKind, Group, InputError, Label, Layout, Pinch
from firstcontact.recording import Header, PinchMark, RecordingWriter, load_dataset, read_recording


@pytest.fixture
def written(tmp_path, layout):
    """Return a function that writes a recording of two pinches, and returns its bytes."""
    slow = Layout((Channel("force", ChannelKind.FORCE, None, "N"),), 100.0)
    layout = Layout(layout.channels, layout.rate, groups=(Group("slow", slow),))

    def write(seed, force=0, start=0, session="1"):
        path = tmp_path / "part.mcap"
        path.unlink(missing_ok=True)
        with RecordingWriter(path, Header(layout, "synthetic", session=session)) as writer:
            for number in range(2):
                first = start + 400 * number
                data = np.random.default_rng([seed, number]).integers(-99, 99, (400, 2), np.int16)
                groups = {"slow": Block(np.full((20, 1), force, np.int16), first // 20)}
                label = Label(shore_a=10.0 + seed)
                writer.pinch(Pinch(data, layout, label, first, groups=groups))
        return path.read_bytes()

    return write


@pytest.mark.parametrize(
    "other",
    [{"seed": 2}, {"seed": 1, "force": 1}, {"seed": 1, "start": 5000, "session": "2"}],
    ids=["other samples", "other samples of a group", "another header"],
)
def test_two_recordings_in_one_file_are_refused(tmp_path, written, other):
    path = tmp_path / "merged.mcap"
    path.write_bytes(written(seed=1) + written(**other))
    for read in (read_recording, load_dataset):
        with pytest.raises(InputError, match=r"merged\.mcap"):
            read(path)


def test_a_recording_that_is_in_a_file_twice_counts_once(tmp_path, written):
    once, twice = tmp_path / "once.mcap", tmp_path / "twice.mcap"
    once.write_bytes(written(seed=1))
    twice.write_bytes(2 * once.read_bytes())
    pinches = load_dataset(once).pinches
    assert [p.data.tolist() for p in load_dataset(twice)] == [p.data.tolist() for p in pinches]
    assert any("800 samples came twice" in loss for loss in load_dataset(twice).losses)


@pytest.mark.parametrize(
    ("number", "first", "is_refused"),
    [(1, 100, True), (0, 300, True), (1, 280, False), (1, 300, False)],
    ids=["half", "number", "edge", "apart"],
)
def test_a_touch_with_two_labels_is_refused(tmp_path, layout, counted, number, first, is_refused):
    path = tmp_path / "marks.mcap"
    with RecordingWriter(path, Header(layout)) as writer:
        writer.write(counted(0, 600))
        writer.mark(PinchMark(0, 0, 300, label=Label("foam", 10.0, session="1")))
        writer.mark(PinchMark(number, first, first + 300, label=Label("wood", 80.0, session="2")))
    if is_refused:
        with pytest.raises(InputError, match=r"marks\.mcap"):
            load_dataset(path)
    else:
        assert load_dataset(path).shore_a.tolist() == [10.0, 80.0]


@pytest.mark.parametrize("options", [{"use_chunking": False}, {"compression": CompressionType.LZ4}])
def test_a_rewritten_recording_is_the_original(tmp_path, written, options):
    original, rewritten = tmp_path / "original.mcap", tmp_path / "rewritten.mcap"
    original.write_bytes(written(seed=1))
    with rewritten.open("wb") as stream:
        writer = Writer(stream, **options)
        writer.start("ros2", "test")
        numbers = {}
        for schema, channel, message in make_reader(BytesIO(written(seed=1))).iter_messages():
            if channel.topic not in numbers:
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                numbers[channel.topic] = writer.register_channel(channel.topic, "json", number)
            writer.add_message(numbers[channel.topic], message.log_time, message.data, 0)
        writer.finish()
    assert read_recording(rewritten).skipped == ()
    for one, other in zip(load_dataset(original), load_dataset(rewritten), strict=True):
        assert np.array_equal(one.data, other.data)
        assert (one.label, one.groups["slow"].data[0, 0]) == (other.label, 0)
