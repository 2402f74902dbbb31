import os
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Block, InputError, Pinch
from firstcontact.core.text import counted as count_text
from firstcontact.recording import Header, RecordingWriter, read_recording
from firstcontact.recording._chunks import MAGIC, find_chunks
from firstcontact.recording._reader import join


def chunk_ends(path):
    """Return the bytes, the ends of all chunks and the recording of an intact file."""
    data = path.read_bytes()
    ends = [stop for _, stop in find_chunks(data)]
    recording = read_recording(path)
    return data, ends, recording


@pytest.fixture
def unclosed(tmp_path, layout, counted):
    """Write a file like that of a writer killed after one second, with two headers."""
    path = tmp_path / "unclosed.mcap"
    with RecordingWriter(tmp_path / "whole.mcap", Header(layout)) as writer:
        for first in range(0, 2000, 70):
            writer.write(counted(first, 70))
        path.write_bytes((tmp_path / "whole.mcap").read_bytes())
    return path


#: Steps through a file: every byte, or some besides the edges of its chunks.
STEPS = pytest.mark.parametrize("step", [37, pytest.param(1, marks=pytest.mark.slow)])


def places(edges, first, last, step):
    """Return each ``step``-th position from ``first`` to before ``last``, and all near edges."""
    about = {edge + near for edge in edges for near in (-2, -1, 0, 1)}
    return sorted({*range(first, last, step), *about} & set(range(first, last)))


@STEPS
def test_truncated_file_gives_all_complete_chunks(small, numbers_agree, step):
    data, ends, intact = chunk_ends(small)
    assert len(ends) > 3
    cut = small.with_name("cut.mcap")
    readable = []
    for length in places([*ends, len(data)], ends[0], len(data), step):
        cut.write_bytes(data[:length])
        recording = read_recording(cut)
        numbers_agree(recording)
        assert recording.skipped
        readable.append(recording.samples)
        complete = sum(end <= length for end in ends)
        assert len(recording.stretches) == (recording.samples > 0)
        # Only the end of a chunk brings new samples, and it does at once.
        previous = readable[-2] if len(readable) > 1 else -1
        assert (recording.samples != previous) <= (length in ends)
        assert complete < len(ends) or recording.samples == intact.samples
    assert readable == sorted(readable)
    for length in places([1, ends[0]], 1, ends[0], step):
        cut.write_bytes(data[:length])
        with pytest.raises(InputError):
            read_recording(cut)


@STEPS
@pytest.mark.parametrize("is_killed", [False, True])
def test_flipped_bit_costs_at_most_its_chunk(small, unclosed, numbers_agree, step, is_killed):
    path = unclosed if is_killed else small
    data, ends, intact = chunk_ends(path)
    starts = [start for start, _ in find_chunks(data)]
    flipped = path.with_name("flipped.mcap")
    for at in places([*starts, *ends, len(data)], 0, len(data), step):
        bad = bytearray(data)
        bad[at] ^= 1 << (at % 8)
        flipped.write_bytes(bad)
        recording = read_recording(flipped)
        numbers_agree(recording)
        touched = any(a <= at < b for a, b in zip(starts, ends, strict=True))
        lost_count = intact.samples - recording.samples
        assert lost_count <= 300  # what one chunk holds at most
        assert not lost_count or (touched and recording.skipped)
        assert recording.header == intact.header


def test_damage_of_the_summary_is_reported(small):
    data, _, intact = chunk_ends(small)
    footer = len(data) - len(MAGIC) - 29  # opcode, length, two positions and a checksum
    (summary,) = struct.unpack_from("<Q", data, footer + 9)
    assert summary < footer
    for at in range(summary, footer, 5):
        bad = bytearray(data)
        bad[at] ^= 0x10
        small.write_bytes(bad)
        recording = read_recording(small)
        assert recording.samples == intact.samples
        assert recording.skipped


def test_lost_marks_are_listed(tmp_path, layout, counted):
    path = tmp_path / "a.mcap"
    with RecordingWriter(path, Header(layout)) as writer:
        for first in range(0, 2000, 400):
            writer.pinch(Pinch(counted(first, 400).data, layout, first_sample=first))
    data = path.read_bytes()
    position = data.index(b'"number":2')
    path.write_bytes(data[:position] + b"!" + data[position + 1 :])
    recording = read_recording(path)
    assert [p.number for p in recording.pinches] == [0, 1, 3, 4]
    assert any("1 pinch" in s for s in recording.skipped)


def test_lost_and_doubled_samples_are_counted(tmp_path, layout, counted):
    path = tmp_path / "a.mcap"
    with RecordingWriter(path, Header(layout)) as writer:
        for first, count in ((0, 50), (100, 50), (60, 40), (140, 30), (0, 0)):
            writer.write(counted(first, count))
    recording = read_recording(path)
    text = " ".join(recording.skipped)
    assert "1 blocks were out of order" in text
    assert "10 samples are missing in 1 gap" in text
    assert "10 samples came twice" in text
    assert [(s.first_sample, s.end) for s in recording.stretches] == [(0, 50), (60, 170)]


@pytest.mark.parametrize(
    "content",
    [b"", b"RIFF....WAVEfmt ", MAGIC[:3], b"\x89MCAP1\r\n" + bytes(50), MAGIC, MAGIC + bytes(1000)],
)
def test_other_files_are_refused(tmp_path, content):
    path = tmp_path / "other.mcap"
    path.write_bytes(content)
    with pytest.raises(InputError, match=path.name):
        read_recording(path)


def test_files_that_cannot_be_opened_are_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe.mcap")  # nobody will ever write to it
    for name, problem in (
        ("", r"\*\.mcap"),
        ("pipe.mcap", r"pipe\.mcap"),
        ("missing.mcap", r"missing\.mcap"),
    ):
        with pytest.raises(InputError, match=problem):
            read_recording(tmp_path / name)


def block(first, end):
    return Block(np.arange(first, end)[:, None], first)


@given(st.lists(st.tuples(st.integers(0, 60), st.integers(0, 12)), max_size=12))
def test_any_blocks_are_joined_without_loss_or_duplicates(parts):
    blocks = [block(first, first + n) for first, n in parts]
    stretches, losses = join(blocks)
    joined_numbers = [i for s in stretches for i in range(s.first_sample, s.end)]
    assert joined_numbers == sorted({i for first, n in parts for i in range(first, first + n)})
    for s in stretches:
        assert s.data[:, 0].tolist() == list(range(s.first_sample, s.end))
    total = sum(n for _, n in parts)
    text = " ".join(losses)
    assert (f"{total - len(joined_numbers)} samples came twice" in text) == (
        total > len(joined_numbers)
    )
    missing = (
        joined_numbers[-1] - joined_numbers[0] + 1 - len(joined_numbers) if joined_numbers else 0
    )
    assert (f"missing in {count_text(len(stretches) - 1, 'gap')}" in text) == (missing > 0)
