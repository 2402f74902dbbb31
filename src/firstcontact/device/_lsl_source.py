"""A stream of the Lab Streaming Layer as a source."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    FINGERTIP_RATE,
    Channel,
    ChannelKind,
    Finger,
    InputError,
    Layout,
    VibrationSensor,
    finger_name,
)
from firstcontact.device._lsl_library import lsl_library
from firstcontact.device._number_lines import distinct_names, place_of
from firstcontact.device._opening import SourceOptions
from firstcontact.device._source import Descriptor
from firstcontact.device._stamped_samples import StampedSamples, usable_stamps
from firstcontact.device._stream_checks import RateCheck
from firstcontact.device._threaded import ThreadedSource
from firstcontact.recording import HIGHEST_RATE, SOURCES

#: A stream is looked for so long, s.
PATIENCE = 5.0
#: Longest wait for a chunk, s: how soon a stop is noticed.
WAIT = 0.02
#: A second stream of the same name is looked for so long, s.
ANOTHER = 0.5
#: A stamp that says that its sample comes from so far in the future, or in the past, s, tells of a
#: clock that was set.
FUTURE, PAST = 1.0, 100.0
#: Fields that tell one sender from another, the plainest first.
_SENDERS = ("hostname", "source_id", "uid")
#: Longest label of a channel, characters.
LONGEST_LABEL = 100
#: What a stream may have sent before this program takes it, s.
BUFFERED = 60


class _Epoch:
    """Numbers of the samples of one epoch, by stamps of one clock."""

    def __init__(self, number: int, rate: float) -> None:
        self.number, self._rate = number, rate
        self.rate = RateCheck(rate)
        self._numbering = StampedSamples(rate)
        self._least = math.inf  # age of a sample that came soonest after it was taken, s
        self._unstamped = 0  # samples before the first usable stamp
        self.count = 0

    @property
    def next(self) -> _Epoch:
        """The epoch that follows."""
        return _Epoch(self.number + 1, self._rate)

    def in_time(self, ago: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return True for each sample whose age, s, fits to those before it."""
        good = usable_stamps(ago)
        if math.isinf(self._least) and good.any():
            self._least = float(np.sort(ago[good])[good.sum() // 2])
        good &= (ago > self._least - FUTURE) & (ago < self._least + PAST)
        self._least = min(self._least, float(ago[good].min(initial=math.inf)))
        return good

    def numbers(self, stamps: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the numbers of the next samples; the stamp of one out of time is NaN."""
        self.count += len(stamps)
        if math.isinf(self._least):
            self._unstamped += len(stamps)
            return np.arange(self._unstamped - len(stamps), self._unstamped)
        return self._numbering.numbers(stamps) + self._unstamped


class LslSource(ThreadedSource):
    """An inlet for a stream with vibration channels.

    Stamps become sample numbers by the sender's clock; what is missing between them is counted as
    lost. LSL's own time correction tells how the sender's clock runs against the host's. A stream
    that is gone is looked for until it is back, with another epoch.

    Parameters
    ----------
    stream
        Its name; where several streams have it, NAME@HOST or NAME@SOURCE_ID.
    channels
        Signals, by label or position from 1 on; none for those whose type is a vibration sensor,
        or for all where there are one or two.
    rate
        Of the samples that come out, Hz.

    Raises
    ------
    InputError
        On entering: LSL is missing, no such stream, several of them, or one that cannot be used.
    """

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

        # InternalError: the port of a sender that just died refuses the connection.
        self._lost = (util.LostError, util.TimeoutError, util.InternalError, TimeoutError)
        found = self._found(PATIENCE)
        if found is None:
            raise InputError(
                f"no LSL stream is called {self._stream!r}: start what sends it, or see "
                "`firstcontact ports --ask`"
            )
        try:
            return self._listen(found)
        except BaseException:
            self._shut()
            raise

    def _found(self, patience: float) -> Any:
        """Look for the stream. Return None without one, InputError with several."""
        predicate = _predicate(self._stream)
        streams = self._lsl.resolve_bypred(predicate, 1, patience)
        if streams:
            streams = self._lsl.resolve_bypred(predicate, 2, ANOTHER) or streams
        if len(streams) > 1:
            raise InputError(
                f"{self.name} is the name of {len(streams)} streams: choose one of "
                f"{', '.join(_distinct_names(streams))}"
            )
        return streams[0] if streams else None

    def _listen(self, found: Any) -> Descriptor:
        """Open the inlet; what the stream says about itself."""
        self._check_rate(found)
        self._inlet = self._lsl.StreamInlet(found, max_buflen=BUFFERED, recover=False)
        try:
            info = self._inlet.info(PATIENCE)
            self._inlet.open_stream(PATIENCE)
            self._inlet.time_correction(PATIENCE)
        except self._lost as error:
            raise InputError(f"{self.name} does not answer ({error}): start it again") from error
        channels, self._places = vibration_of(info, self._named, self.name)
        delay = self._resample(float(info.nominal_srate()), self._rate)
        said = info.desc().child("acquisition")
        source = said.child_value("source")
        return Descriptor(
            Layout(channels, self._rate),
            firmware=f"LSL, from {self._input_rate:g} Hz",
            sensor=f"{info.name()} ({info.type()})",
            hand=said.child_value("hand"),
            source=source if source in SOURCES else "unknown",
            dtype="float32",
            delay=delay,
        )

    def _check_rate(self, info: Any) -> None:
        """Refuse a stated rate that cannot be used, before anything is sent."""
        rate = float(info.nominal_srate())
        if not rate > 0 or info.channel_format() == self._lsl.cf_string:
            raise InputError(
                f"{self.name} has no regular rate, or text for samples: have it sent with the rate "
                "of its samples"
            )
        if rate > HIGHEST_RATE:
            raise InputError(
                f"{self.name} says {rate:g} samples a second, and {HIGHEST_RATE:g} are "
                "the most: correct the rate that it states"
            )
        if self._rate > 10 * rate:
            raise InputError(
                f"{self.name} has {rate:g} samples a second: a contact needs "
                f"{self._rate / 10:.0f} or more"
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
                # LSL knows how far the sender's clock is apart from that of the host.
                ago = self._lsl.local_clock() - self._inlet.time_correction(PATIENCE)
            except self._lost:
                self._note(connected=False)
                if not self._back():
                    return
                epoch = epoch.next
                continue
            values = np.asarray(chunk, np.float64)[:, self._places]
            epoch = self._take(epoch, values, np.asarray(stamps), host, ago)

    def _take(
        self,
        epoch: _Epoch,
        values: NDArray[np.float64],
        stamps: NDArray[np.float64],
        host: float,
        clock: float,
    ) -> _Epoch:
        """Give a chunk. Return its epoch, another one where the sender's clock was set.

        Parameters
        ----------
        epoch
            That is going on.
        values, stamps
            Samples, shape (samples, channels), and their stamps, s, shape (samples,).
        host, clock
            Time now by the host's clock, and by the sender's, s.
        """
        ago = clock - stamps
        good = epoch.in_time(ago)
        if not good.any() and usable_stamps(stamps).any():
            epoch = epoch.next
            good = epoch.in_time(ago)
        values[~good] = np.nan
        numbers = epoch.numbers(np.where(good, stamps, np.nan))
        taken = host - float(ago[good][-1]) if good.any() else None
        self._give(values, numbers, epoch.number, host, taken)
        if good[-1] and epoch.rate.add(epoch.count, float(stamps[-1])):
            self._refuse_rate(epoch.rate.rate / self._input_rate, "its own")
        return epoch

    def _back(self) -> bool:
        """Look for the stream until it is there again; False when closed before that."""
        self._shut()
        before = self.descriptor.layout
        while not self._closing.is_set():
            with suppress(InputError):
                found = self._found(0.5)
                if found is None:
                    continue
                descriptor = self._listen(found)
                if descriptor.layout == before:
                    return True
                break
        if self._closing.is_set():
            return False
        raise InputError(f"{self.name} came back with other channels: begin again")

    def _shut(self) -> None:
        inlet, self._inlet = self._inlet, None
        if inlet is not None:
            inlet.close_stream()


def vibration_of(
    info: Any, wanted: tuple[str, ...], name: str
) -> tuple[tuple[Channel, ...], list[int]]:
    """The channels that are given as samples, and where they are in the stream.

    Raises
    ------
    InputError
        One that is wanted is not there, or it cannot be told which are meant.
    """
    told = []
    node = info.desc().child("channels").child("channel")
    for k in range(info.channel_count()):
        words = {w: node.child_value(w) for w in ("label", "type", "unit", "finger")}
        told.append({**words, "label": words["label"][:LONGEST_LABEL] or str(k + 1)})
        node = node.next_sibling()
    labels = distinct_names([t["label"] for t in told])
    kinds = {str(v) for v in VibrationSensor}
    if wanted:
        found = [place_of(w, labels) for w in wanted]
        places = [] if None in found else [k for k in found if k is not None]
    else:
        places = [k for k, t in enumerate(told) if t["type"].lower() in kinds]
        places = places or (list(range(len(told))) if len(told) <= 2 else [])
    if not 1 <= len(set(places)) == len(places) <= 2:
        raise InputError(
            f"{name}: which one or two of its channels are the vibration is not known: name them, "
            f"as in {name}#{(*labels, '1')[0]} (there are {', '.join(labels[:16])})"
        )
    fingers = {finger_name(f): f for f in Finger}
    of_hand: list[Finger | None] = [fingers.get(told[k]["finger"]) for k in places]
    if len(set(of_hand)) < len(places):
        of_hand = list(Finger)
    channels = tuple(
        Channel(
            labels[k],
            ChannelKind.VIBRATION,
            finger,
            told[k]["unit"][:LONGEST_LABEL],
            sensor=VibrationSensor(t) if (t := told[k]["type"].lower()) in kinds else None,
        )
        for k, finger in zip(places, of_hand, strict=True)
    )
    return channels, places


def _predicate(stream: str) -> str:
    """Return the XPath query for a stream's name, or for NAME@HOST and NAME@SOURCE_ID."""
    words = stream.split("@")
    queries = [f"name={_literal(stream)}"]
    for k in range(1, len(words)):
        where = _literal("@".join(words[k:]))
        of_sender = " or ".join(f"{field}={where}" for field in _SENDERS)
        queries.append(f"(name={_literal('@'.join(words[:k]))} and ({of_sender}))")
    return " or ".join(queries)


def _literal(text: str) -> str:
    """Return an XPath expression for any text; XPath has no escape for quotes."""
    if "'" not in text:
        return f"'{text}'"
    pieces = text.split("'")
    return "concat('" + "', \"'\", '".join(pieces) + "')"


def _distinct_names(streams: Sequence[Any]) -> list[str]:
    """Return a name for each stream that no other one of them has, in order."""
    names = []
    for stream in streams:
        for field in _SENDERS:
            where = getattr(stream, field)()
            if where and [getattr(s, field)() for s in streams].count(where) == 1:
                names.append(f"lsl:{stream.name()}@{where}")
                break
    return sorted(names)


def from_name(name: str, options: SourceOptions) -> LslSource:
    """The stream that a person names: lsl:NAME, or lsl:NAME#LABEL,LABEL."""
    options.check_own_speed(name)
    stream, _, channels = name.removeprefix("lsl:").partition("#")
    if not stream:
        raise InputError("lsl: names no stream: as in lsl:NAME")
    if not stream.isprintable():  # the query goes over the network as a line of text
        raise InputError(f"{name!r} has characters that no stream's name has: name it as it is")
    return LslSource(stream, tuple(word for word in channels.split(",") if word))
