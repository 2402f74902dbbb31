"""A sound input as a source: one or two channels, brought to the rate that models take."""

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

from firstcontact.core import FINGERTIP_RATE, InputError, VibrationSensor, require_modules
from firstcontact.device._opening import SourceOptions
from firstcontact.device._source import Descriptor
from firstcontact.device._stream_checks import RateCheck
from firstcontact.device._threaded import ThreadedSource
from firstcontact.recording import FileSettings, make_layout

#: What the system may hold back, s, more is an overflow; blocks come in a quarter of it ...
LATENCY = 0.016
#: ... but where the number of blocks can be chosen (ALSA): as long ones, and more of them.
BLOCKS = 32
#: Where the next block is due is the median over so many.
STEADY = 31
#: A gap is no longer than the time since the block before, and the blocks that waited: s.
SLACK = 1.0
#: Letting go of an input that hangs is waited for so long, s.
FAREWELL = 2.0


class _Heard(NamedTuple):
    """A block as PortAudio has given it; times of its own clock and of the monotonic one, s."""

    data: NDArray[np.float32]
    taken: float
    host: float
    overflow: bool


class AudioSource(ThreadedSource):
    """A sound input through PortAudio.

    What the input lost before this program could take it (an overflow) is counted with its
    length, which PortAudio's times of sampling tell to about a sample. An input that is
    unplugged ends the source: what comes back may be another one.

    Parameters
    ----------
    wanted
        Its name, a part of it that only it has, or its number; "" for the system's own.
    channels
        1 or 2; two are those of index finger and thumb.
    rate
        Of the samples that come out, Hz.

    Raises
    ------
    InputError
        On entering: PortAudio is missing, there is no such input or several, or it is in use.
    """

    def __init__(self, wanted: str = "", channels: int = 1, rate: float = FINGERTIP_RATE) -> None:
        super().__init__("audio" + (f":{wanted}" if wanted else ""))
        self._wanted_input, self._channels, self._rate = wanted, channels, rate
        self._heard: SimpleQueue[_Heard] = SimpleQueue()
        # What follows belongs to PortAudio's thread.
        self._pace = RateCheck(rate)
        self._frames = 0
        self._is_too_fast = False
        self._stream: Any = None

    def _open(self) -> Descriptor:
        sound = portaudio()
        device = _device(sound, self._wanted_input)
        if device["max_input_channels"] < self._channels:
            raise InputError(
                f"{self.name} has {device['max_input_channels']} channel: leave /2 out"
            )
        delay = self._resample(float(device["default_samplerate"]), self._rate)
        self._pace = RateCheck(self._input_rate)
        try:
            self._stream = sound.InputStream(
                device=device["index"],
                channels=self._channels,
                samplerate=self._input_rate,
                dtype="float32",
                latency=_latency(),
                callback=self._called,
            )
            self._stream.start()
        except (sound.PortAudioError, ValueError) as error:
            self._shut()
            raise InputError(
                f"{self.name} cannot be opened ({error}): close what else uses it, or see "
                "`firstcontact ports`"
            ) from error
        settings = FileSettings(VibrationSensor.PIEZO, self._rate, "full scale", 1.0, "real", None)
        layout = make_layout(settings, self._channels, scale=1.0)
        if self._channels == 1:  # a disc by itself: of no finger
            (channel,) = layout.channels
            channel = replace(channel, name=VibrationSensor.PIEZO.value, finger=None)
            layout = replace(layout, channels=(channel,))
        return Descriptor(
            layout,
            firmware=f"PortAudio, from {self._input_rate:g} Hz",
            sensor=f"sound input {device['name']}",
            source="real",
            dtype="float32",
            delay=delay,
        )

    def _called(self, data: NDArray[np.float32], frames: int, times: Any, status: Any) -> None:
        """PortAudio's own thread: only hand over, unless the input keeps no pace."""
        host = time.monotonic()
        self._frames += frames
        # An input without a pace gives more than any other thread can take. One that is too slow
        # has lost samples, which are counted there.
        differs = self._pace.add(self._frames, host)
        if differs and self._pace.rate > self._input_rate:
            self._is_too_fast = True
            raise portaudio().CallbackAbort
        taken, overflow = times.inputBufferAdcTime, bool(status.input_overflow)
        self._heard.put(_Heard(data.copy(), taken, host, overflow))

    def _work(self) -> None:
        end, overflows, last = 0, 0, time.monotonic()
        starts: deque[float] = deque(maxlen=STEADY)  # when sample 0 was taken, by each block
        while not self._closing.is_set():
            if self._is_too_fast:
                self._refuse_rate(self._pace.rate / self._input_rate, "this machine's")
            try:
                heard = self._heard.get(timeout=0.05)
            except Empty:
                if self._wait():  # PortAudio does not tell
                    raise InputError(
                        f"{self.name} gives no samples any more: plug it in and begin again"
                    ) from None
                continue
            if heard.overflow and starts:
                due = float(np.median(starts)) + end / self._input_rate
                gap = heard.taken - due
                # An input that does not tell its time tells nothing about the gap.
                passed = 0.0 <= gap <= heard.host - last + SLACK
                lost = max(1, round(gap * self._input_rate)) if passed else 1
                end += lost
                overflows += lost
                share = self._rate / self._input_rate
                self._note(overflow_samples=round(overflows * share))
            last = heard.host
            if np.isfinite(heard.taken):
                starts.append(heard.taken - end / self._input_rate)
            numbers = np.arange(end, end + len(heard.data))
            self._give(heard.data, numbers, 0, heard.host)
            end += len(heard.data)

    def _shut(self) -> None:
        stream, self._stream = self._stream, None
        if stream is None:
            return
        # An input that is gone can keep PortAudio from ever coming back.
        letting_go = threading.Thread(target=stream.abort, name=f"end {self.name}", daemon=True)
        letting_go.start()
        letting_go.join(FAREWELL)
        if not letting_go.is_alive():
            stream.close()


def portaudio() -> Any:
    """The package that speaks to PortAudio.

    Raises
    ------
    InputError
        It is missing, or the library is.
    """
    require_modules("audio", "sounddevice")
    try:
        import sounddevice
    except OSError as error:
        raise InputError(
            f"sound inputs need the PortAudio library ({error}): install it (on Debian: "
            "`sudo apt install libportaudio2`)"
        ) from error
    return sounddevice


def _latency() -> float:
    """What to ask for: for ALSA, PortAudio is first told of how many blocks it is to be, s."""
    with suppress(OSError, AttributeError, TypeError):
        library = ctypes.CDLL(ctypes.util.find_library("portaudio") or "")
        library.PaAlsa_SetNumPeriods(BLOCKS)
        return LATENCY * BLOCKS / 4
    return LATENCY


def inputs(sound: Any) -> list[dict[str, Any]]:
    """The sound inputs there are."""
    return [d for d in sound.query_devices() if d["max_input_channels"] > 0]


def _device(sound: Any, wanted: str) -> dict[str, Any]:
    """The input that is meant."""
    there = inputs(sound)
    if not there:
        raise InputError(
            "no sound input is here: plug one in, and see that this user may open it (on Debian: "
            "the group audio)"
        )
    if not wanted:
        usual = sound.default.device[0]
        return next((d for d in there if d["index"] == usual), there[0])
    found = [d for d in there if wanted in (d["name"], str(d["index"]))]
    found = found or [d for d in there if wanted.lower() in d["name"].lower()]
    if len(found) != 1:
        names = ", ".join(repr(d["name"]) for d in found or there)
        raise InputError(
            f"audio:{wanted} is {'no input' if not found else 'several inputs'}: choose one of "
            f"{names}"
        )
    return found[0]


def discover() -> Iterator[tuple[str, str]]:
    """The inputs as ``ports`` lists them; none where PortAudio is missing."""
    try:
        sound = portaudio()
    except InputError:
        return
    for device in inputs(sound):
        channels = device["max_input_channels"]
        yield (
            f"audio:{device['name']}",
            f"sound input, {channels} channel{'s' if channels > 1 else ''}, "
            f"{device['default_samplerate']:g} Hz",
        )


def from_name(name: str, options: SourceOptions) -> AudioSource:
    """The input that a person names: audio, audio:NAME, with /2 behind it two channels."""
    options.check_own_speed(name)
    wanted, _, channels = name.rpartition("/") if name.endswith(("/1", "/2")) else (name, "", "1")
    return AudioSource(wanted.partition(":")[2], int(channels))
