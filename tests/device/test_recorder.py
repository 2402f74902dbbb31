import os
import signal
import subprocess
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import forked
from firstcontact.core import Block, Channel, ChannelKind, Finger, InputError, Label, Layout
from firstcontact.device import Arrival
from firstcontact.device.recorder import QUEUED, Recorder
from firstcontact.recording import (
    Header,
    Marker,
    PinchMark,
    Recording,
    RecordingWriter,
    read_recording,
)
from processes import full_disk, until

LAYOUT = Layout(
    (
        Channel("piezo_index", ChannelKind.VIBRATION, Finger.INDEX, "V", 0.001),
        Channel("piezo_thumb", ChannelKind.VIBRATION, Finger.THUMB, "V", 0.001),
    ),
    2000.0,
)
HEADER = Header(LAYOUT, "synthetic")


def numbered_block(first: int, samples: int, epoch: int = 0) -> Block:
    """Return a block whose samples contain their numbers, as low and high bits."""
    number = np.arange(first, first + samples, dtype=np.int64)
    return Block(np.stack([number & 0x7FFF, number >> 15], axis=1).astype(np.int16), first, epoch)


def arrivals(first: int, lengths: list[int], epoch: int = 0) -> Iterator[Arrival]:
    """Yield consecutive blocks of these lengths."""
    for length in lengths:
        yield Arrival(numbered_block(first, length, epoch), 0.0)
        first += length


def check_numbers(recording: Recording) -> None:
    for stretch in recording.stretches:
        expected = numbered_block(stretch.first_sample, len(stretch.data)).data
        assert np.array_equal(stretch.data, expected)


@given(st.lists(st.integers(1, 700), min_size=1, max_size=30), st.integers(0, 3))
def test_all_blocks_are_recorded(lengths, epoch):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.mcap"
        with Recorder() as recorder:
            recorder.start(path, HEADER)
            for arrival in arrivals(50, lengths, epoch):
                recorder.put([arrival])
        recording = read_recording(path)
    assert recorder.status.samples == sum(lengths)
    assert (recorder.status.path, recorder.status.waiting, recorder.status.failed) == (None, 0, "")
    assert [(s.first_sample, s.end, s.epoch) for s in recording.stretches] == [
        (50, 50 + sum(lengths), epoch)
    ]
    check_numbers(recording)
    assert recording.skipped == ()


def test_gaps_epochs_marks_and_markers_are_recorded(tmp_path):
    path = tmp_path / "Größe 指.mcap"
    mark = PinchMark(0, 10, 60, 0, Label("block 29", 29.0))
    with Recorder() as recorder:
        recorder.start(path, HEADER)
        recorder.put(arrivals(0, [5] * 20))
        recorder.mark(mark)
        recorder.put([Arrival(numbered_block(130, 10), 0.0, (Marker(133, "twin: block 29"),))])
        recorder.put(arrivals(0, [5, 5], epoch=1))
    recording = read_recording(path)
    assert [(s.first_sample, s.end, s.epoch) for s in recording.stretches] == [
        (0, 100, 0),
        (130, 140, 0),
        (0, 10, 1),
    ]
    assert recording.pinches == (mark,)
    assert recording.markers == (Marker(133, "twin: block 29"),)
    assert any("30 samples are missing in 1 gap" in s for s in recording.skipped)


def test_second_recording_at_a_time_is_refused(tmp_path):
    with Recorder() as recorder:
        recorder.start(tmp_path / "a.mcap", HEADER)
        recorder.put(arrivals(0, [10]))
        with pytest.raises(InputError, match=r"a\.mcap"):
            recorder.start(tmp_path / "b.mcap", HEADER)
        recorder.stop()
        with pytest.raises(InputError, match=r"a\.mcap"):
            recorder.start(tmp_path / "a.mcap", HEADER)
        recorder.start(tmp_path / "b.mcap", HEADER)
        recorder.put(arrivals(0, [20]))
    with pytest.raises(InputError, match=r"c\.mcap"):
        recorder.start(tmp_path / "c.mcap", HEADER)
    assert [read_recording(tmp_path / f"{n}.mcap").samples for n in "ab"] == [10, 20]


def test_invalid_block_stops_only_the_recording(tmp_path):
    with Recorder() as recorder:
        recorder.start(tmp_path / "a.mcap", HEADER)
        recorder.put(arrivals(0, [400]))
        recorder.put([Arrival(Block(np.zeros((5, 3), np.int16), 400), 0.0)])
        until(lambda: recorder.status.failed)
        recorder.put(arrivals(405, [100]))
        status = recorder.status
        assert "2 columns" in status.failed
        assert (status.path, status.waiting) == (None, 0)
        recorder.start(tmp_path / "b.mcap", HEADER)
        assert recorder.status.failed == ""
    assert read_recording(tmp_path / "a.mcap").samples == 400


def test_a_file_at_its_limit_stops_the_recording_with_an_error(tmp_path):
    path, end = tmp_path / "a.mcap", 0
    with full_disk(40_000), Recorder() as recorder:
        recorder.start(path, HEADER)
        while not recorder.status.failed:
            recorder.put(arrivals(end, [64]))
            end += 64
    status = recorder.status
    assert str(path) in status.failed
    assert "make room" in status.failed
    assert (status.path, status.waiting) == (None, 0)
    recording = read_recording(path)
    (stretch,) = recording.stretches
    check_numbers(recording)
    assert status.samples - 0.1 * LAYOUT.rate <= stretch.end <= end
    assert any("not closed" in s for s in recording.skipped)


@pytest.mark.parametrize("is_stopped", [True, False])
def test_a_caller_can_wait_for_a_slow_disk(tmp_path, monkeypatch, is_stopped):
    recorder = Recorder()
    works_again, asked = threading.Event(), threading.Event()
    path = tmp_path / "a.mcap"
    recorder.start(path, HEADER)

    def stopped():
        asked.set()
        return is_stopped

    write = RecordingWriter.write

    def write_late(writer, block):
        works_again.wait()
        write(writer, block)

    monkeypatch.setattr(RecordingWriter, "write", write_late)
    recorder.put(arrivals(0, [500] * 200))
    waiting = threading.Thread(target=recorder.wait, args=(stopped,))
    waiting.start()
    asked.wait()
    if is_stopped:
        waiting.join()
        assert recorder.status.waiting == 100_000
    works_again.set()
    waiting.join()
    if not is_stopped:
        assert recorder.status.waiting <= QUEUED
    recorder.stop()
    assert read_recording(path).samples == 100_000


# Records as fast as it can and says how far it got; its parent kills it.
RECORDING = """
import os, sys
from pathlib import Path
sys.path.insert(0, sys.argv[2])
from test_recorder import HEADER, arrivals
from firstcontact.device.recorder import Recorder
recorder = Recorder()
recorder.start(Path(sys.argv[1]), HEADER)
end = 0
while True:
    recorder.put(arrivals(end, [37]))
    end += 37
    while recorder.status.waiting > 2000:
        pass
    os.write(1, b"%d\\n" % (end - recorder.status.waiting))
"""


@pytest.mark.parametrize("seed", [0, 1])
def test_killed_recorder_leaves_all_complete_chunks(tmp_path, seed):
    path = tmp_path / "killed.mcap"
    lines = int(np.random.default_rng(seed).integers(1, 1500))
    words = (RECORDING, path, Path(__file__).parent)
    with forked.Program("code", *words, stdout=subprocess.PIPE) as child:
        for _ in range(lines):
            written_samples = int(child.stdout.readline())
        os.kill(child.pid, signal.SIGKILL)
        last_lines = child.stdout.read().splitlines()[:-1]
        written_samples = max([written_samples, *map(int, last_lines)])
    recording = read_recording(path)
    check_numbers(recording)
    assert sum(s.first_sample != 0 for s in recording.stretches) == 0  # nothing is missing before
    assert recording.samples >= written_samples - 0.1 * LAYOUT.rate
    assert any("not closed" in s for s in recording.skipped)
