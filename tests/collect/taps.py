"""Recording of taps at known samples, without pinch marks."""

from pathlib import Path

import numpy as np

from firstcontact.core import Block, Channel, ChannelKind, Group, Layout
from firstcontact.recording import Header, Marker, RecordingWriter

RATE = 8000.0
SLOW = Layout((Channel("grip", ChannelKind.FORCE, None, "N"),), 100.0)
PIEZO = Channel("disc", ChannelKind.VIBRATION, None, "V", 0.001)
LAYOUT = Layout((PIEZO,), RATE, groups=(Group("100_hz", SLOW),))


def taps(n: int, every: float = 0.25) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Return the sample numbers of the taps."""
    return np.round((0.3 + every * np.arange(n)) * RATE).astype(np.int64)


def write_taps(path: Path, n: int = 8, every: float = 0.25) -> Path:
    """Write a quiet recording with taps at the samples of :func:`taps`."""
    rng = np.random.default_rng(0)
    signal = rng.normal(0, 3, round((0.6 + every * n) * RATE))
    t = np.arange(400) / RATE
    for at in taps(n, every):
        signal[at : at + 400] += 2000 * np.exp(-t / 0.01) * np.sin(2 * np.pi * 400 * t + 0.5)
    slow = np.arange(len(signal) // 80, dtype=np.int16)[:, None]
    with RecordingWriter(path, Header(LAYOUT, "synthetic", session="monday")) as writer:
        writer.write(Block(signal.astype(np.int16)[:, None], 0))
        writer.write(Block(slow, 0), "100_hz")
        writer.marker(Marker(5, "begun"))
    return path
