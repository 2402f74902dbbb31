"""WAV files of killed or careless programs: their samples are read, with a note."""

import struct

import numpy as np
import pytest
import soundfile
from import_files import RATE, imported


def wav_bytes(riff=None, data=None, tail=b"", before=b"", keep=None, order="<"):
    """Return a WAV file of 500 samples with these lengths in its header."""
    pcm = np.arange(500).astype(f"{order}i2").tobytes()
    form = struct.pack(f"{order}IHHIIHH", 16, 1, 1, RATE, RATE * 2, 2, 16)
    size = struct.pack(f"{order}I", len(pcm) if data is None else data)
    body = b"WAVEfmt " + form + before + b"data" + size + pcm[:keep] + tail
    length = struct.pack(f"{order}I", len(body) if riff is None else riff)
    return (b"RIFF" if order == "<" else b"RIFX") + length + body


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize(
    ("wrong", "samples"),
    [
        ({"riff": 0}, 500),
        ({"riff": 0, "data": 0}, 500),
        ({"riff": 0xFFFFFFFF, "data": 0xFFFFFFFF}, 500),
        ({"riff": 0x7FFFFFFF}, 500),
        ({"riff": 36}, 500),
        ({"data": 1044}, 500),
        ({"tail": b"ID3"}, 500),
        ({"tail": b"\xff\x01" * 40}, 500),
        ({"data": 0, "before": b"junk\3\0\0\0abc"}, 500),
        ({"keep": 701}, 350),
    ],
    ids=str,
)
def test_samples_are_read_whatever_lengths_the_header_states(tmp_path, wrong, samples, order):
    if order == ">" and "before" in wrong:
        wrong = {**wrong, "before": b"junk\0\0\0\3abc"}
    path = tmp_path / "a.wav"
    path.write_bytes(wav_bytes(order=order, **wrong))
    dataset = imported(path, tmp_path / "out")
    assert np.array_equal(dataset[0].data[:, 0], np.arange(samples))
    assert sum(note.startswith("a.wav: ") for note in dataset.notes) == 1


@pytest.mark.parametrize(
    "right",
    [{}, {"before": b"LIST\4\0\0\0INFO"}, {"tail": b"LIST\4\0\0\0INFO"}, {"tail": b"id3 \0\0\0\0"}],
)
def test_right_lengths_need_no_note(tmp_path, right):
    path = tmp_path / "a.wav"
    path.write_bytes(wav_bytes(**right))
    dataset = imported(path, tmp_path / "out")
    assert len(dataset[0].data) == 500
    assert not any(note.startswith("a.wav: ") for note in dataset.notes)


@pytest.mark.parametrize("subtype", ["ULAW", "ALAW", "IMA_ADPCM", "PCM_24", "DOUBLE"])
def test_any_samples_that_libsndfile_reads_are_read(tmp_path, subtype):
    tone = np.sin(np.arange(5000) / 9) * 0.5
    soundfile.write(tmp_path / "a.wav", tone, RATE, subtype)
    dataset = imported(tmp_path / "a.wav", tmp_path / "out")
    assert np.abs(dataset[0].vibration()[:5000, 0] - tone).mean() < 0.01
