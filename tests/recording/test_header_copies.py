"""Recordings have two copies of the header, so that one damaged byte does not lose everything."""

from dataclasses import replace

import numpy as np
import pytest

from firstcontact.core import Block, InputError, fingertip_layout
from firstcontact.recording import Header, Marker, RecordingWriter, read_recording
from firstcontact.recording.messages import LONGEST_TEXT

HEADER = Header(fingertip_layout(), "synthetic", session="1", notes="the only ones")


@pytest.fixture
def killed(tmp_path):
    """Write a file like that of a writer killed after one second of samples."""
    path = tmp_path / "whole.mcap"
    killed_path = tmp_path / "killed.mcap"
    with RecordingWriter(path, HEADER) as writer:
        for first in range(0, 4900, 70):
            number = np.arange(first, first + 70, dtype=np.int16)
            writer.write(Block(np.repeat(number[:, None], 16, axis=1), first))
        killed_path.write_bytes(path.read_bytes())
    return killed_path


def test_flipped_byte_costs_at_most_its_chunk(killed):
    intact = read_recording(killed)
    data = killed.read_bytes()
    for at in (*range(0, 64), *range(64, 9000, 37), *range(9000, len(data), 997)):
        bad = bytearray(data)
        bad[at] ^= 0xFF
        killed.write_bytes(bad)
        recording = read_recording(killed)
        assert recording.header == HEADER
        assert intact.samples - recording.samples <= 0.1 * HEADER.layout.rate


def test_recording_at_the_highest_rate_is_read(tmp_path):
    """The padding after the first header is longer than the longest JSON."""
    path = tmp_path / "a.mcap"
    header = Header(replace(HEADER.layout, rate=1e7), "synthetic", "float32")
    with RecordingWriter(path, header) as writer:
        writer.write(Block(np.ones((1000, 16), np.float32)))
    recording = read_recording(path)
    assert (recording.header, recording.samples, recording.skipped) == (header, 1000, ())


def test_invalid_header_leaves_no_file(tmp_path):
    path = tmp_path / "a.mcap"
    for header in (
        Header(HEADER.layout, session="\udcff"),  # a name that is not UTF-8, as arguments can be
        Header(HEADER.layout, session="x" * 300),
        Header(HEADER.layout, notes="x" * 200_000),
    ):
        with pytest.raises(InputError, match="the header"):
            RecordingWriter(path, header)
        assert not path.exists()


def test_invalid_marker_text_does_not_end_a_recording(tmp_path):
    path = tmp_path / "a.mcap"
    with RecordingWriter(path, HEADER) as writer:
        writer.marker(Marker(3, "half \udcff"))
        writer.marker(Marker(4, "x" * (LONGEST_TEXT + 1)))
    recording = read_recording(path)
    half, long = recording.markers
    assert half.text == "half ?"
    assert long.text == "x" * (LONGEST_TEXT - 1) + "…"
    assert recording.skipped == ()
