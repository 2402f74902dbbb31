"""Source that plays a sound file as if its sensor were connected: ``tape:FILE.wav``."""

from __future__ import annotations

import logging
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FileError
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.core.plausible import are_alike
from firstcontact.device.audio_source import sound_descriptor
from firstcontact.device.descriptor import Descriptor
from firstcontact.device.opening import SourceOptions, check_speed
from firstcontact.device.threaded import ThreadedSource
from firstcontact.recording.settings import check_rate
from firstcontact.recording.sound import FULL_SCALE, read_sound

_log = logging.getLogger("firstcontact.device")

#: Length of a block, s, like that of a sound input.
BLOCK = 0.005


class TapeSource(ThreadedSource):
    """Source that plays a WAV or FLAC file of one or two channels, at a multiple of real time."""

    def __init__(self, path: Path, speed: float) -> None:
        super().__init__(f"tape:{path}")
        self._path, self._speed = path, speed
        self._values: NDArray[np.float32] = np.zeros((0, 1), np.float32)
        self._behind = speed != 1.0  # the rate is checked against this machine's clock

    def _open(self) -> Descriptor:
        if not self._path.exists():
            raise FileError(f"{self._path} does not exist: check the path")
        rate, stored = read_sound(self._path)
        check_rate(f"{self._path}: the sample rate", rate)
        if stored.shape[1] > 2:
            raise FileError(
                f"{self._path} has {stored.shape[1]} channels: reduce them to one, or to one for "
                "each finger"
            )
        if stored.shape[1] == 2 and are_alike(*stored.T):
            _log.warning("%s: both channels are one signal, so the first is used alone", self.name)
            stored = stored[:, :1]
        delay = self._resample(rate, FINGERTIP_RATE)
        values = (stored / FULL_SCALE[str(stored.dtype)]).astype(np.float32)
        # The filter delays its output: the last value goes on until the last sample is out.
        after = np.repeat(values[-1:], round(2 * delay * rate) + 1, axis=0)
        self._values = np.concatenate([values, after])
        described = f"tape, from {rate:g} Hz", f"sound file {self._path.name}", "unknown"
        return sound_descriptor(FINGERTIP_RATE, stored.shape[1], *described, delay)

    def _work(self) -> None:
        began, size = time.monotonic(), max(round(BLOCK * self._input_rate), 1)
        for start in range(0, len(self._values), size):
            end = min(start + size, len(self._values))
            due = began + end / self._input_rate / self._speed
            if self._closing.wait(max(due - time.monotonic(), 0.0)):
                return
            self._give(self._values[start:end], np.arange(start, end), 0, due)

    def _shut(self) -> None:
        self._values = self._values[:0]


def from_name(name: str, options: SourceOptions) -> TapeSource:
    check_speed(options.speed)
    return TapeSource(Path(name.partition(":")[2]), options.speed)
