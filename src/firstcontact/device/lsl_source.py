"""A stream of the Lab Streaming Layer as a source."""

from __future__ import annotations

import time
from contextlib import suppress
from typing import Any

import numpy as np

from firstcontact.core import (
    Channel,
    ChannelKind,
    Finger,
    InputError,
    Layout,
    VibrationSensor,
    finger_name,
)
from firstcontact.core.extras import install_command, need
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.device._stamped_samples import StampedSamples
from firstcontact.device.opening import SourceOptions
from firstcontact.device.source import Descriptor
from firstcontact.device.threaded import ThreadedSource
from firstcontact.recording.checks import HIGHEST_RATE
from firstcontact.recording.header import SOURCES
from firstcontact.signal import CausalResampler

#: A stream is looked for so long, s.
PATIENCE = 5.0
#: Longest wait for a chunk, s: how soon a stop is noticed.
WAIT = 0.02
#: A stream that sends nothing for so long is not there, s.
SILENCE = 1.0
#: What a stream may have sent before this program takes it, s.
BUFFERED = 60


class LslSource(ThreadedSource):
    """An inlet for a stream with vibration channels.

    Stamps become sample numbers by the sender's clock; what is missing between them is counted as
    lost. LSL's own time correction tells how the sender's clock runs against the host's. A stream
    that is gone is looked for until it is back, with another epoch.

    Parameters
    ----------
    stream
        Its name.
    channels
        Signals, by label or position from 1 on; none for those whose type is a vibration sensor,
        or for all where there are one or two.
    rate
        Of the samples that come out, Hz.

    Raises
    ------
    InputError
        On entering: LSL is missing, no such stream, or one that cannot be used.
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
        self._input_rate = rate

    def _open(self) -> Descriptor:
        self._lsl = _library()
        from pylsl import util

        self._lost = (util.LostError, TimeoutError, getattr(util, "TimeoutError", TimeoutError))
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
        streams = self._lsl.resolve_byprop("name", self._stream, 1, patience)
        return streams[0] if streams else None

    def _listen(self, found: Any) -> Descriptor:
        """Open the inlet; what the stream says about itself."""
        self._inlet = self._lsl.StreamInlet(found, max_buflen=BUFFERED, recover=False)
        try:
            info = self._inlet.info(PATIENCE)
            self._check_rate(info)
            self._inlet.open_stream(PATIENCE)
            self._inlet.time_correction(PATIENCE)
        except self._lost as error:
            raise InputError(f"{self.name} does not answer ({error}): start it again") from error
        channels, self._places = vibration_of(info, self._named, self.name)
        resampler = CausalResampler(self._input_rate, self._rate)
        said = info.desc().child("acquisition")
        source = said.child_value("source")
        return Descriptor(
            Layout(channels, self._rate),
            firmware=f"LSL, from {self._input_rate:g} Hz",
            sensor=f"{info.name()} ({info.type()})",
            hand=said.child_value("hand"),
            source=source if source in SOURCES else "unknown",
            dtype="float32",
            delay=resampler.delay,
        )

    def _check_rate(self, info: Any) -> None:
        """Take the rate that it states, before anything is sent."""
        self._input_rate = float(info.nominal_srate())
        if not self._input_rate > 0 or info.channel_format() == self._lsl.cf_string:
            raise InputError(
                f"{self.name} has no regular rate, or text for samples: have it sent with the rate "
                "of its samples"
            )
        if self._input_rate > HIGHEST_RATE:
            raise InputError(
                f"{self.name} says {self._input_rate:g} samples a second, and {HIGHEST_RATE:g} are "
                "the most: correct the rate that it states"
            )
        if self._rate > 10 * self._input_rate:
            raise InputError(
                f"{self.name} has {self._input_rate:g} samples a second: a contact needs "
                f"{self._rate / 10:.0f} or more"
            )

    def _work(self) -> None:
        epoch = 0
        while not self._closing.is_set():
            try:
                self._take(epoch)
            except self._lost:
                self._note(connected=False)
                if not self._back():
                    return
                epoch += 1

    def _take(self, epoch: int) -> None:
        """Give what comes until closed; LostError when the stream is gone."""
        numbering = StampedSamples(self._input_rate)
        resampler = CausalResampler(self._input_rate, self._rate)
        last = time.monotonic()
        while not self._closing.is_set():
            chunk, stamps = self._inlet.pull_chunk(timeout=WAIT, max_samples=4096)
            now = time.monotonic()
            if not len(stamps):
                if now - last > SILENCE:
                    self._note(connected=False)
                continue
            last = now
            # When the newest was taken, by the host's clock: LSL knows how far the two are apart.
            ago = self._lsl.local_clock() - stamps[-1] - self._inlet.time_correction(PATIENCE)
            values = np.asarray(chunk, np.float64)[:, self._places]
            numbers = numbering.numbers(np.asarray(stamps))
            edges = np.flatnonzero(np.diff(numbers) > 1) + 1
            for part, its in zip(np.split(values, edges), np.split(numbers, edges), strict=True):
                # What is not finite nobody can resample: it is a gap.
                good = np.asarray(np.isfinite(part).all(axis=1))
                for run in np.split(np.arange(len(part)), np.flatnonzero(np.diff(good)) + 1):
                    if good[run[0]]:
                        out, first = resampler.update(part[run], int(its[run[0]]))
                        self._put(out.astype(np.float32), first, epoch, now, now - ago)

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
        told.append({**words, "label": words["label"] or str(k + 1)})
        node = node.next_sibling()
    labels = [t["label"] for t in told]
    kinds = {str(v) for v in VibrationSensor}
    if wanted:
        places = [
            labels.index(w) if w in labels else int(w) - 1 if w.isdecimal() else -1 for w in wanted
        ]
    else:
        places = [k for k, t in enumerate(told) if t["type"].lower() in kinds]
        places = places or (list(range(len(told))) if len(told) <= 2 else [])
    if not 1 <= len(places) <= 2 or not all(0 <= k < len(told) for k in places):
        raise InputError(
            f"{name}: which one or two of its channels are the vibration is not known: name them, "
            f"as in {name}#{labels[0]} (there are {', '.join(labels[:16])})"
        )
    fingers = {finger_name(f): f for f in Finger}
    of_hand: list[Finger | None] = [fingers.get(told[k]["finger"]) for k in places]
    if len(set(of_hand)) < len(places):
        of_hand = list(Finger)
    channels = tuple(
        Channel(
            told[k]["label"],
            ChannelKind.VIBRATION,
            finger,
            told[k]["unit"],
            sensor=VibrationSensor(t) if (t := told[k]["type"].lower()) in kinds else None,
        )
        for k, finger in zip(places, of_hand, strict=True)
    )
    return channels, places


def _library() -> Any:
    need("live", "pylsl")
    try:
        import pylsl
    except RuntimeError as error:  # the library of C is not there
        raise InputError(f"LSL needs liblsl ({error}): {install_command('live')}") from error
    return pylsl


def from_name(name: str, options: SourceOptions) -> LslSource:
    """The stream that a person names: lsl:NAME, or lsl:NAME#LABEL,LABEL."""
    options.check_own_speed(name)
    stream, _, channels = name.removeprefix("lsl:").partition("#")
    if not stream:
        raise InputError("lsl: names no stream: as in lsl:NAME")
    return LslSource(stream, tuple(word for word in channels.split(",") if word))
