"""Memory for reading: it is that of the samples in use, not of the whole recording."""

import pickle
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from firstcontact.core import Block, InputError, fingertip_layout
from firstcontact.device.replay import ReplaySource
from firstcontact.recording import Header, PinchMark, RecordingWriter, load_dataset, read_recording

LAYOUT = fingertip_layout()
#: Bytes that a longer recording may need for the places of its samples.
PLACES = 400_000


def load_pinches(path: Path) -> None:
    assert len(load_dataset(path)) == 4


def read_all(path: Path) -> None:
    assert read_recording(path).samples > 0


def read_doubled(path: Path) -> None:
    assert "came twice" in " ".join(read_recording(path).skipped)


def replay(path: Path) -> None:
    with ReplaySource(path, float("inf")) as source:
        while not source.ended:
            source.read(1.0)
        assert source.health.samples == source.recording.samples


def peak(use: Callable[[Path], None], path: Path) -> int:
    """Return the most bytes in use at once."""
    tracemalloc.start()
    try:
        use(path)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("is_damaged", [False, True])
@pytest.mark.parametrize("use", [read_all, read_doubled, load_pinches, replay])
def test_peak_does_not_grow_with_the_recording(
    use: Callable[[Path], None], is_damaged: bool, tmp_path: Path
) -> None:
    peaks = []
    for seconds in (20, 80):
        path = tmp_path / f"{seconds}.mcap"
        data = np.random.default_rng(0).integers(0, 16000, (494, 16)).astype(np.int16)
        with RecordingWriter(path, Header(LAYOUT)) as writer:
            for k in range(10 * seconds):
                for _ in range(1 + (use is read_doubled)):
                    writer.write(Block(data, 494 * k))
            for number in range(4):
                writer.mark(PinchMark(number, 9000 * number, 9000 * number + 5000))
        if is_damaged:
            with path.open("r+b") as file:
                file.seek(path.stat().st_size * 19 // 20)
                file.write(bytes(100))
        if not peaks:
            peak(use, path)  # imports what it needs
        peaks.append(peak(use, path))
    assert peaks[1] < peaks[0] + PLACES
    assert peaks[1] < path.stat().st_size / 2


def test_recording_that_changes_while_it_is_read_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with RecordingWriter(path, Header(LAYOUT)) as writer:
        writer.write(Block(np.zeros((5000, 16), np.int16)))
    recording = read_recording(path)
    path.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(InputError, match=path.name):
        assert recording.stretches[0].data.size


def test_samples_in_a_file_can_be_sent_to_another_process(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with RecordingWriter(path, Header(LAYOUT, "synthetic", "int16")) as writer:
        writer.write(Block(np.arange(160, dtype=np.int16).reshape(10, 16), 5))
    (stretch,) = read_recording(path).stretches
    assert repr(stretch) == "Stretch(5 to 15, epoch 0)"
    sent = pickle.loads(pickle.dumps(stretch))
    path.unlink()
    assert (sent.first_sample, sent.end) == (5, 15)
    assert np.array_equal(sent.data, stretch.data)
