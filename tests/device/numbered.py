"""Samples that contain their own number, so that tests detect lost or moved samples."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, fingertip_layout
from firstcontact.device import Descriptor
from firstcontact.device.protocol import FRAME_SAMPLES, FrameType, encode, samples_payload

DESCRIPTOR = Descriptor(fingertip_layout(), "test firmware", "test", "", "synthetic")
CHANNELS = len(DESCRIPTOR.layout.channels)
#: What terminals and protocols are known to stumble over: NUL, CR LF, XON, XOFF, ETX, ESC.
HOSTILE = np.array(
    [0x0000, 0x0A0D, 0x0D0A, 0x1311, 0x1113, 0x0003, 0x1B04, 0x7F00, 0x007F, -1, -256, 255, 26, 28],
    dtype=np.int16,
)


def numbered(first: int, count: int) -> NDArray[np.int16]:
    """Return samples, shape (count, 16). The first two columns hold the sample number, 32 bits."""
    data = np.empty((count, CHANNELS), dtype=np.int16)
    data[:, 2:] = HOSTILE
    numbers = (np.arange(first, first + count) & 0xFFFFFFFF).astype("<u4")
    data[:, :2] = numbers.view("<i2").reshape(-1, 2)
    return data


def frames(
    first: int, count: int, counter: int = 0, overflow: int = 0, size: int = FRAME_SAMPLES
) -> list[bytes]:
    """Return numbered samples as frames."""
    out = []
    for k, start in enumerate(range(first, first + count, size)):
        data = numbered(start, min(size, first + count - start))
        out.append(encode(FrameType.SAMPLES, counter + k, samples_payload(start, overflow, data)))
    return out


def check(blocks: Iterable[Block]) -> int:
    """Assert that all sample numbers are correct and occur once. Return the number of samples."""
    count = 0
    ends: dict[int, int] = {}
    epoch = 0
    for block in blocks:
        assert block.epoch >= epoch
        epoch = block.epoch
        assert block.first_sample >= ends.get(epoch, 0)
        assert len(block.data)
        np.testing.assert_array_equal(block.data, numbered(block.first_sample, len(block.data)))
        ends[epoch] = block.end
        count += len(block.data)
    return count


def stretches(blocks: Iterable[Block]) -> list[tuple[int, int, int]]:
    """Return epoch, first sample and end of each run of blocks without a gap."""
    runs: list[tuple[int, int, int]] = []
    for block in blocks:
        if runs and runs[-1][::2] == (block.epoch, block.first_sample):
            runs[-1] = (block.epoch, runs[-1][1], block.end)
        else:
            runs.append((block.epoch, block.first_sample, block.end))
    return runs
