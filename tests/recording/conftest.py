"""Recording of a small device whose first channel counts the samples, so that every loss shows.

Also a check that ``import`` refuses a file.
"""

import numpy as np
import pytest

from firstcontact.cli.main import main
from firstcontact.core import Block, Channel, ChannelKind, Finger, Layout
from firstcontact.recording import Header, RecordingWriter


@pytest.fixture
def layout():
    channels = (
        Channel("piezo_index", ChannelKind.VIBRATION, Finger.INDEX, "V", 0.001),
        Channel("piezo_thumb", ChannelKind.VIBRATION, Finger.THUMB, "V", 0.001),
    )
    return Layout(channels, 2000.0)


@pytest.fixture
def counted():
    """Return a function that makes a block whose channels hold the sample number."""

    def make(first, samples, epoch=0):
        number = np.arange(first, first + samples)
        return Block(np.stack([number, -number], axis=1).astype(np.int16), first, epoch)

    return make


@pytest.fixture
def small(tmp_path, layout, counted):
    """Write a closed recording of 350 samples in blocks of 70."""
    path = tmp_path / "small.mcap"
    with RecordingWriter(path, Header(layout, "synthetic")) as writer:
        for first in range(0, 350, 70):
            writer.write(counted(first, 70))
    return path


@pytest.fixture
def numbers_agree():
    """Return a function that asserts that every sample holds its own number."""

    def check(recording):
        for stretch in recording.stretches:
            number = np.arange(stretch.first_sample, stretch.end)
            assert np.array_equal(stretch.data, np.stack([number, -number], axis=1))

    return check


@pytest.fixture
def check_refused(tmp_path, capsys):
    """Return a function that runs ``import`` and asserts a refusal.

    The refusal must be one short sentence with the given words, and nothing may be written.
    """

    def check(path, *words, **options):
        out = tmp_path / "refused"
        given = [word for name, value in options.items() for word in (f"--{name}", str(value))]
        assert main(["import", str(path), "--out", str(out), *given]) == 2
        message = capsys.readouterr().err
        assert message.count("\n") == 1
        assert len(message) < 1000
        assert "\x1b" not in message
        for word in words:
            assert word in message, message
        assert not out.exists()

    return check
