"""Source for a stream of the Lab Streaming Layer (LSL)."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Channel, DeviceError, InputError, Layout, VibrationSensor
from firstcontact.core.installation import install_command, require_modules
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.core.units import known_unit
from firstcontact.device.clock import RateCheck
from firstcontact.device.columns import distinct_names, select_signals, vibration_channels
from firstcontact.device.descriptor import Descriptor
from firstcontact.device.opening import SourceOptions
from firstcontact.device.stamped_samples import StampedSamples, usable_stamps
from firstcontact.device.threaded import ThreadedSource
from firstcontact.recording.messages import SOURCES
from firstcontact.recording.settings import HIGHEST_RATE, LOWEST_RATE

#: Longest search for a stream, s.
PATIENCE = 5.0
#: Longest wait for a chunk, s. It limits the time until a stop is noticed.
WAIT = 0.02
#: Longest search for a second stream of the same name, s.
ANOTHER = 0.5
#: A stamp further in the future or past than this, s, means that the sender's clock was set.
FUTURE, PAST = 1.0, 100.0
#: Fields that distinguish senders, the most readable one first.
_SENDERS = ("hostname", "source_id", "uid")
#: Longest label of a channel, characters.
LONGEST_LABEL = 100
#: Length of the inlet's buffer, s.
BUFFERED = 60


def lsl_library() -> Any:
    """Import pylsl, set to log only warnings and errors, and return the module."""
    require_modules("live", "pylsl")
    try:
        import pylsl
    except RuntimeError as error:  # the C library is missing
        raise DeviceError(
            f"LSL needs the library liblsl ({error}): install it with {install_command('live')}"
        ) from error
    # Without a settings file of the user, liblsl prints its settings on standard error.
    files = ("lsl_api.cfg", "~/lsl_api/lsl_api.cfg", "/etc/lsl_api/lsl_api.cfg")
    has_file = any(map(os.path.exists, map(os.path.expanduser, files)))
    if "LSLAPICFG" not in os.environ and not has_file:
        with suppress(AttributeError, NotImplementedError):  # liblsl before 1.17.7
            pylsl.set_config_content("[log]\nlevel = -1\n")
    return pylsl


class _Epoch:
    """Numbering of samples by the sender's time stamps, until the sender's clock jumps.

    A jump begins a new epoch, which has the next ``number``. ``rate`` is the stated rate, Hz.
    """

    def __init__(self, number: int, rate: float) -> None:
        self.number, self._rate = number, rate
        self.rate = RateCheck(rate)
        self._numbering = StampedSamples(rate)
        self._least = math.inf  # smallest age of a sample at arrival, s
        self._unstamped = 0  # number of samples before the first usable stamp
        self.count = 0
        self._newest = -math.inf  # newest stamp
        self._steps = self._backward = 0  # number of steps between stamps, and of steps back

    def has_plausible_stamp(self, ago: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return a mask that is True for samples with a plausible time stamp, shape (samples,).

        ``ago`` is the age of each sample when it arrived, s: the arrival minus the time stamp.
        """
        good = usable_stamps(ago)
        if math.isinf(self._least) and good.any():
            self._least = float(np.sort(ago[good])[good.sum() // 2])
        good &= (ago > self._least - FUTURE) & (ago < self._least + PAST)
        self._least = min(self._least, float(ago[good].min(initial=math.inf)))
        return good

    def runs_backwards(self, stamps: NDArray[np.float64]) -> bool:
        """Return True if more than 3 of 4 stamps of a second are smaller than the stamp before."""
        stamps = np.append(self._newest, stamps[usable_stamps(stamps)])
        self._backward += int((np.diff(stamps) < 0).sum())
        self._steps += len(stamps) - 1
        self._newest = float(stamps[-1])
        if self._steps < self._rate:
            return False
        share = self._backward / self._steps
        self._steps = self._backward = 0
        return share > 0.75

    def numbers(self, stamps: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the sample number of each time stamp, s. Implausible stamps must be NaN."""
        self.count += len(stamps)
        if math.isinf(self._least):
            self._unstamped += len(stamps)
            return np.arange(self._unstamped - len(stamps), self._unstamped)
        return self._numbering.numbers(stamps) + self._unstamped


class LslSource(ThreadedSource):
    """Source that receives an LSL stream with vibration channels."""

    def __init__(
        self, stream: str, channels: tuple[str, ...] = (), rate: float = FINGERTIP_RATE
    ) -> None:
        super().__init__(f"lsl:{stream}")
        self._stream, self._named, self._rate = stream, channels, rate
        self._lsl: Any = None
        self._lost: tuple[type[Exception], ...] = ()
        self._inlet: Any = None
        self._places: list[int] = []

    def _open(self) -> Descriptor:
        self._lsl = lsl_library()
        from pylsl import util

        # InternalError: the port of a stopped sender refuses the connection.
        self._lost = (util.LostError, util.TimeoutError, util.InternalError, TimeoutError)
        info = self._find(PATIENCE)
        if info is None:
            raise DeviceError(
                f"no LSL stream is called {self._stream!r}: start its sender, or see "
                "`firstcontact ports --ask`"
            )
        try:
            return self._listen(info)
        except BaseException:
            self._shut()
            raise

    def _find(self, patience: float) -> Any:
        predicate = _stream_query(self._stream)
        streams = self._lsl.resolve_bypred(predicate, 1, patience)
        if streams:
            streams = self._lsl.resolve_bypred(predicate, 2, ANOTHER) or streams
        if len(streams) > 1:
            raise DeviceError(
                f"{self.name} is the name of {len(streams)} streams: choose one of "
                f"{', '.join(_distinct_names(streams))}"
            )
        return streams[0] if streams else None

    def _listen(self, stream: Any) -> Descriptor:
        self._check_rate(stream)
        self._inlet = self._lsl.StreamInlet(stream, max_buflen=BUFFERED, recover=False)
        try:
            info = self._inlet.info(PATIENCE)
            self._inlet.open_stream(PATIENCE)
            self._inlet.time_correction(PATIENCE)
        except self._lost as error:
            raise DeviceError(
                f"{self.name} does not answer ({error}): start the sender of this stream again"
            ) from error
        channels, self._places = stream_channels(info, self._named, self.name)
        delay = self._resample(float(info.nominal_srate()), self._rate)
        acquisition = info.desc().child("acquisition")
        source = acquisition.child_value("source")
        return Descriptor(
            Layout(channels, self._rate),
            firmware=f"LSL, from {self._input_rate:g} Hz",
            sensor=f"{info.name()} ({info.type()})",
            hand=acquisition.child_value("hand"),
            source=source if source in SOURCES else "unknown",
            dtype="float32",
            delay=delay,
        )

    def _check_rate(self, info: Any) -> None:
        rate = float(info.nominal_srate())
        if info.channel_format() == self._lsl.cf_string:
            raise DeviceError(f"{self.name} carries text: choose a stream of numbers")
        if not LOWEST_RATE <= rate <= HIGHEST_RATE:
            raise DeviceError(
                f"{self.name} states a rate of {rate:g} Hz in the field 'nominal_srate': let the "
                f"sender state its rate, from {LOWEST_RATE:g} to {HIGHEST_RATE:g} Hz"
            )

    def _work(self) -> None:
        epoch = _Epoch(0, self._input_rate)
        while not self._closing.is_set():
            try:
                chunk, stamps = self._inlet.pull_chunk(timeout=WAIT, max_samples=4096)
                if not len(stamps):
                    self._wait()
                    continue
                host = time.monotonic()
                # The time correction is the difference of the clocks of sender and host.
                ago = self._lsl.local_clock() - self._inlet.time_correction(PATIENCE)
            except self._lost:
                self._note(connected=False)
                if not self._reconnect():
                    return
                epoch = _Epoch(epoch.number + 1, self._input_rate)
                continue
            values = np.asarray(chunk, np.float64)[:, self._places]
            epoch = self._deliver(epoch, values, np.asarray(stamps), host, ago)

    def _deliver(
        self,
        epoch: _Epoch,
        values: NDArray[np.float64],
        stamps: NDArray[np.float64],
        host: float,
        clock: float,
    ) -> _Epoch:
        """Deliver samples to the reader. Return their epoch.

        It is ``epoch``, or a new one if the sender's clock jumped. ``host`` is the time of arrival
        on ``time.monotonic()``, and ``clock`` the same time on the clock of ``stamps``, in s.
        """
        if epoch.runs_backwards(stamps):
            raise DeviceError(
                f"the time stamps of {self.name} run backwards: correct the program that sends them"
            )
        ages = clock - stamps
        fits = epoch.has_plausible_stamp(ages)
        if not fits.any() and usable_stamps(stamps).any():
            epoch = _Epoch(epoch.number + 1, self._input_rate)
            fits = epoch.has_plausible_stamp(ages)
        values[~fits] = np.nan
        numbers = epoch.numbers(np.where(fits, stamps, np.nan))
        taken = host - float(ages[fits][-1]) if fits.any() else None
        self._give(values, numbers, epoch.number, host, taken)
        if fits[-1] and epoch.rate.add(epoch.count, float(stamps[-1])):
            self._refuse_rate(epoch.rate.rate / self._input_rate, "its own")
        return epoch

    def _reconnect(self) -> bool:
        """Search for the lost stream. Return True once it is connected again.

        Return False if the source closes first. Raises DeviceError if the stream comes back with
        other channels.
        """
        self._shut()
        while not self._closing.is_set():
            descriptor = None
            with suppress(InputError):  # several streams of this name, or an unusable one
                if (info := self._find(0.5)) is not None:
                    descriptor = self._listen(info)
            if descriptor is not None:
                if descriptor.layout == self.descriptor.layout:
                    return True
                raise DeviceError(
                    f"{self.name} came back with other channels: start the command again"
                )
        return False

    def _shut(self) -> None:
        inlet, self._inlet = self._inlet, None
        if inlet is not None:
            inlet.close_stream()


def stream_channels(
    info: Any, names: tuple[str, ...], name: str
) -> tuple[tuple[Channel, ...], list[int]]:
    metadata = []
    node = info.desc().child("channels").child("channel")
    for k in range(info.channel_count()):
        words = {
            w: node.child_value(w)[:LONGEST_LABEL] for w in ("label", "type", "unit", "finger")
        }
        metadata.append({**words, "label": words["label"] or str(k + 1)})
        node = node.next_sibling()
    labels = distinct_names([t["label"] for t in metadata])
    kinds = {str(v) for v in VibrationSensor}
    signals = [k for k, t in enumerate(metadata) if t["type"].lower() in kinds]
    places = select_signals(name, labels, names, signals or list(range(len(metadata))))
    units = [known_unit(metadata[k]["unit"]) for k in places]
    return vibration_channels([{**metadata[k], "label": labels[k]} for k in places], units), places


def _stream_query(stream: str) -> str:
    """Return the XPath query for a stream. ``stream`` is NAME, NAME@HOST or NAME@SOURCE_ID."""
    words = stream.split("@")
    queries = [f"name={_xpath_literal(stream)}"]
    for k in range(1, len(words)):
        sender = _xpath_literal("@".join(words[k:]))
        of_sender = " or ".join(f"{field}={sender}" for field in _SENDERS)
        queries.append(f"(name={_xpath_literal('@'.join(words[:k]))} and ({of_sender}))")
    return " or ".join(queries)


def _xpath_literal(text: str) -> str:
    """Return an XPath expression for a text. XPath cannot escape quotes: concat joins the parts."""
    if "'" not in text:
        return f"'{text}'"
    pieces = text.split("'")
    return "concat('" + "', \"'\", '".join(pieces) + "')"


def _distinct_names(streams: Sequence[Any]) -> list[str]:
    names = []
    for stream in streams:
        for field in _SENDERS:
            sender = getattr(stream, field)()
            if sender and [getattr(s, field)() for s in streams].count(sender) == 1:
                names.append(f"lsl:{stream.name()}@{sender}")
                break
    return sorted(names)


def from_name(name: str, options: SourceOptions) -> LslSource:
    options.check_own_speed(name)
    stream, _, channels = name.removeprefix("lsl:").partition("#")
    if not stream:
        raise DeviceError("the device 'lsl:' names no stream: give one, as in lsl:NAME")
    if not stream.isprintable():  # the query is sent as one line of text
        raise DeviceError(f"{name!r} has unprintable characters: use the stream's exact name")
    return LslSource(stream, tuple(word for word in channels.split(",") if word))
