"""Source for a sound input: one or two channels, resampled to the rate of the models."""

from __future__ import annotations

import ctypes
import ctypes.util
import threading
import time
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from queue import Empty, SimpleQueue
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import DeviceError, InputError, VibrationSensor
from firstcontact.core.installation import require_modules
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.core.units import Unit
from firstcontact.device.descriptor import Descriptor
from firstcontact.device.opening import SourceOptions
from firstcontact.device.threaded import ThreadedSource
from firstcontact.recording.settings import FileSettings, make_layout

#: Length of the system's buffer of four blocks, s; samples that wait longer are lost.
LATENCY = 0.016
#: Number of blocks in the buffer where it can be set (ALSA). A block keeps its length.
BLOCKS = 32
#: Number of newest blocks whose sampling times predict the sampling time of the next block.
STEADY = 31
#: A gap is implausible if it exceeds the time since the previous block by more than this, s.
SLACK = 1.0
#: Longest wait for an input to close, s.
CLOSING_TIME = 2.0


class _InputBlock(NamedTuple):
    data: NDArray[np.float32]
    taken: float
    host: float
    overflow: bool


class AudioSource(ThreadedSource):
    def __init__(
        self, input_name: str = "", channels: int = 1, rate: float = FINGERTIP_RATE
    ) -> None:
        super().__init__("audio" + (f":{input_name}" if input_name else ""))
        self._input_name, self._channels, self._rate = input_name, channels, rate
        self._blocks: SimpleQueue[_InputBlock] = SimpleQueue()
        self._stream: Any = None

    def _open(self) -> Descriptor:
        sound = portaudio()
        device = _find_input(sound, self._input_name)
        if device["max_input_channels"] < self._channels:
            raise DeviceError(
                f"{self.name} has {device['max_input_channels']} channel, but its name asks for "
                "two: leave out the /2"
            )
        delay = self._resample(float(device["default_samplerate"]), self._rate)
        try:
            self._stream = sound.InputStream(
                device=device["index"],
                channels=self._channels,
                samplerate=self._input_rate,
                dtype="float32",
                latency=_prepare_latency(),
                callback=self._callback,
            )
            self._stream.start()
        except (sound.PortAudioError, ValueError) as error:
            self._shut()
            raise DeviceError(
                f"{self.name} cannot be opened ({error}): close the program that uses it, or see "
                "`firstcontact ports`"
            ) from error
        described = (
            f"PortAudio, from {self._input_rate:g} Hz",
            f"sound input {device['name']}",
            "real",
        )
        return sound_descriptor(self._rate, self._channels, *described, delay)

    def _callback(self, data: NDArray[np.float32], frames: int, times: Any, status: Any) -> None:
        taken, overflow = times.inputBufferAdcTime, bool(status.input_overflow)
        self._blocks.put(_InputBlock(data.copy(), taken, time.monotonic(), overflow))

    def _work(self) -> None:
        end, overflows, last = 0, 0, time.monotonic()
        starts: deque[float] = deque(maxlen=STEADY)  # time of sample 0, computed from each block
        while not self._closing.is_set():
            try:
                block = self._blocks.get(timeout=0.05)
            except Empty:
                if self._wait():  # PortAudio does not report an unplugged input
                    raise DeviceError(
                        f"{self.name} sends no samples any more: plug it in and start again"
                    ) from None
                continue
            if block.overflow and starts:
                due = float(np.median(starts)) + end / self._input_rate
                gap = block.taken - due
                # Without sampling times the length of the gap is unknown.
                is_plausible = 0.0 <= gap <= block.host - last + SLACK
                lost = max(1, round(gap * self._input_rate)) if is_plausible else 1
                end += lost
                overflows += lost
                share = self._rate / self._input_rate
                self._note(overflow_samples=round(overflows * share))
            last = block.host
            if np.isfinite(block.taken):
                starts.append(block.taken - end / self._input_rate)
            numbers = np.arange(end, end + len(block.data))
            self._give(block.data, numbers, 0, block.host)
            end += len(block.data)

    def _shut(self) -> None:
        stream, self._stream = self._stream, None
        if stream is None:
            return
        # PortAudio can hang when an input was unplugged.
        closer = threading.Thread(target=stream.abort, name=f"end {self.name}", daemon=True)
        closer.start()
        closer.join(CLOSING_TIME)
        if not closer.is_alive():
            stream.close()


def sound_descriptor(
    rate: float, channels: int, firmware: str, sensor: str, source: str, delay: float
) -> Descriptor:
    layout = make_layout(
        FileSettings(VibrationSensor.PIEZO, rate, Unit("full scale")), channels, scale=1.0
    )
    if channels == 1:  # a single disc belongs to no finger
        (channel,) = layout.channels
        channel = replace(channel, name=VibrationSensor.PIEZO.value, finger=None)
        layout = replace(layout, channels=(channel,))
    return Descriptor(layout, firmware, sensor, source=source, dtype="float32", delay=delay)


def portaudio() -> Any:
    require_modules("audio", "sounddevice")
    try:
        import sounddevice
    except OSError as error:
        raise DeviceError(
            f"sound inputs need the PortAudio library ({error}): install it (on Debian: "
            "`sudo apt install libportaudio2`)"
        ) from error
    return sounddevice


def _prepare_latency() -> float:
    """Set the number of PortAudio's buffers, on Linux. Return the latency to request, s."""
    with suppress(OSError, AttributeError, TypeError):
        library = ctypes.CDLL(ctypes.util.find_library("portaudio") or "")
        library.PaAlsa_SetNumPeriods(BLOCKS)
        return LATENCY * BLOCKS / 4
    return LATENCY


def _inputs(sound: Any) -> list[dict[str, Any]]:
    return [d for d in sound.query_devices() if d["max_input_channels"] > 0]


def _find_input(sound: Any, name: str) -> dict[str, Any]:
    """Return PortAudio's description of a sound input.

    ``name`` is the input's name, a part of it, or its index; "" selects the default input. Raises
    DeviceError unless ``name`` fits exactly one input.
    """
    available = _inputs(sound)
    if not available:
        raise DeviceError(
            "there is no sound input: plug one in, and check that this user may open it (on "
            "Debian: the group audio)"
        )
    if not name:
        default = sound.default.device[0]
        return next((d for d in available if d["index"] == default), available[0])
    matches = [d for d in available if name in (d["name"], str(d["index"]))]
    matches = matches or [d for d in available if name.lower() in d["name"].lower()]
    if len(matches) != 1:
        names = ", ".join(repr(d["name"]) for d in matches or available)
        raise DeviceError(
            f"audio:{name} fits {'no input' if not matches else 'several inputs'}: choose one of "
            f"{names}"
        )
    return matches[0]


def discover() -> Iterator[tuple[str, str]]:
    """Yield (device name, description) of each sound input; nothing if PortAudio is missing."""
    try:
        sound = portaudio()
    except InputError:
        return
    for device in _inputs(sound):
        channels = device["max_input_channels"]
        yield (
            f"audio:{device['name']}",
            f"sound input, {channels} channel{'s' if channels > 1 else ''}, "
            f"{device['default_samplerate']:g} Hz",
        )


def from_name(name: str, options: SourceOptions) -> AudioSource:
    options.check_own_speed(name)
    prefix_and_name, _, channels = (
        name.rpartition("/") if name.endswith(("/1", "/2")) else (name, "", "1")
    )
    return AudioSource(prefix_and_name.partition(":")[2], int(channels))
