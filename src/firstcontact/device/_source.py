"""What a source of samples is: a fingertip on a port, the twin, a recording being replayed."""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any, Protocol, Self

from firstcontact.core import Block, InputError, Layout, Name, VibrationSensor, read_record
from firstcontact.device._device_predictions import DevicePrediction, DevicePredictor, ModelSlot
from firstcontact.recording import SOURCES, Marker, PinchMark

_FLASH = "flash the firmware that belongs to this version of firstcontact"


@dataclass(frozen=True, slots=True)
class _DescriptorJson:
    """What a device sends: every field must be there."""

    firmware: Name
    sensor: Name
    hand: Name
    source: Name
    layout: Layout
    answers: DevicePredictor | None = None
    models: ModelSlot | None = None
    paced: bool = True


def layout_to_send(layout: Layout) -> dict[str, Any]:
    """A layout as version 1 of the protocol has it: piezos by their kind, their smoothing once.

    Of other sensors the form is that of recordings; readers know both.
    """
    alphas = {c.smoothing_alpha for c in layout.vibration}
    plain = all(
        c.sensor is VibrationSensor.PIEZO and c.finger is not None for c in layout.vibration
    )
    if not plain or layout.groups or len(alphas) != 1 or layout.width > len(layout.channels):
        return layout.to_json()
    names = ("name", "kind", "finger", "unit", "scale", "offset", "taxel")
    channels = [{name: getattr(c, name) for name in names} for c in layout.channels]
    for sent, channel in zip(channels, layout.channels, strict=True):
        sent["kind"] = channel.sensor or channel.kind
    return {"channels": channels, "rate": layout.rate, "smoothing_alpha": alphas.pop()}


@dataclass(frozen=True, slots=True)
class Descriptor:
    """What a device says about itself when asked. "" means not known.

    Parameters
    ----------
    layout
        The columns of a sample and their rate.
    firmware, sensor, hand
        What sends.
    source
        "real", "twin", "synthetic" or "unknown", as in a recording's header.
    dtype
        Of the samples; a device on the wire sends int16.
    delay
        So much later than its instant the source's own filter lets a sample out, s.
    predictor
        Model that predicts on the device itself; None without one.
    model_slot
        Models that the device accepts; None if it accepts none.
    paced
        Whether a device sends its samples in real time.
    """

    layout: Layout
    firmware: str = ""
    sensor: str = ""
    hand: str = ""
    source: str = "unknown"
    dtype: str = "int16"
    delay: float = 0.0
    predictor: DevicePredictor | None = None
    model_slot: ModelSlot | None = None
    paced: bool = True

    def to_text(self) -> str:
        """JSON, as it goes over the wire."""
        tree: dict[str, Any] = {
            "firmware": self.firmware,
            "sensor": self.sensor,
            "hand": self.hand,
            "source": self.source,
            "layout": layout_to_send(self.layout),
        }
        if self.predictor is not None:
            tree["answers"] = asdict(self.predictor)
        if self.model_slot is not None:
            tree["models"] = asdict(self.model_slot)
        if not self.paced:
            tree["paced"] = False
        return json.dumps(tree, separators=(",", ":"), ensure_ascii=False)

    @classmethod
    def from_text(cls, text: str) -> Self:
        """The inverse of :meth:`to_text`.

        Raises
        ------
        InputError
            It is not JSON, a field is missing or out of bounds, or no layout of
            fingertips.
        """
        said = read_record(text.encode(), _DescriptorJson, "the device's descriptor", _FLASH)
        fault = said.layout.fault
        if not fault and said.source not in SOURCES:
            fault = f"the source {said.source!r}, not one of {', '.join(SOURCES)}"
        if fault:
            raise InputError(f"the device's descriptor has {fault}: {_FLASH}")
        return cls(
            said.layout,
            said.firmware,
            said.sensor,
            said.hand,
            said.source,
            predictor=said.answers,
            model_slot=said.models,
            paced=said.paced,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Arrival:
    """Consecutive samples, and when the host had the last byte of them.

    Parameters
    ----------
    block
        The samples; sample numbers are 64 bits.
    host
        ``time.monotonic()``, s.
    markers
        Words pinned to samples that came with them. A word pinned to a sample that never
        came is with the last ones, or with none at all behind them.
    pinches
        Marks of the pinches that end in them (only a replayed recording has these).
    predictions
        Contacts and estimates of a device that answers by itself, as they came: of these samples,
        of earlier ones or of some that are on their way.
    """

    block: Block
    host: float
    markers: tuple[Marker, ...] = ()
    pinches: tuple[PinchMark, ...] = ()
    predictions: tuple[DevicePrediction, ...] = ()


@dataclass(frozen=True, slots=True)
class Health:
    """How a source is doing, counted since it was opened.

    Parameters
    ----------
    connected
        Whether the device is there now.
    epoch
        Of the newest sample.
    samples
        Received.
    lost_samples
        Missing in the device's count, for whatever reason; exact for all that
        lies between two samples received, or before a ``stopped`` frame.
    overflow_samples
        Of these, the ones that the device says it dropped itself.
    unusable_samples
        Of the lost ones, those that were NaN, infinite or out of range.
    lost_frames
        Missing in the device's count of frames.
    bad_frames
        Damaged on the way; each is also one of the lost ones.
    doubled_frames
        Came twice or out of order and were left out.
    late_answers
        Of a device that answers by itself: left out, because the next was due.
    unheard_samples
        Of such a device: sent, and missed by its own answers.
    reconnects
        Times that the device came back; each begins an epoch.
    host_rate
        Samples per second of the host's clock over the last epoch, Hz; 0 before
        it can be told.
    losses_known
        Whether the device counts its samples, so that missing ones show.
    ended
        Whether nothing more can come, as after the last sample of a recording.
    """

    connected: bool = False
    epoch: int = 0
    samples: int = 0
    lost_samples: int = 0
    overflow_samples: int = 0
    unusable_samples: int = 0
    lost_frames: int = 0
    bad_frames: int = 0
    doubled_frames: int = 0
    late_answers: int = 0
    unheard_samples: int = 0
    reconnects: int = 0
    host_rate: float = 0.0
    losses_known: bool = True
    ended: bool = False

    @property
    def lost(self) -> str:
        """How many samples are missing, in words."""
        unknown = "" if self.losses_known else " or more (nothing counts them)"
        return f"{self.lost_samples}{unknown}"


class Source(Protocol):
    """Gives samples as they come, in order, each once.

    Opened by ``with``. A thread of its own takes them off the line, whatever
    its reader does meanwhile; :meth:`read` may be called from one thread.
    """

    @property
    def name(self) -> str:
        """What a person calls it: the port, "twin" or the file."""

    @property
    def descriptor(self) -> Descriptor:
        """What it says about itself; known once it is open."""

    @property
    def health(self) -> Health:
        """Counts up to now; may be asked from any thread."""

    @property
    def ended(self) -> bool:
        """Whether nothing more will come, all that came was read and every error raised."""

    def read(self, timeout: float, least: int = 1) -> list[Arrival]:
        """All that has come since the last call, waiting up to ``timeout`` s for so much.

        Parameters
        ----------
        timeout
            Longest wait, s; then whatever there is, or nothing.
        least
            Samples worth waking up for: with fewer the reader could do nothing yet.

        Raises
        ------
        InputError
            The device is not the one that was opened any more (another layout),
            or its port is gone for good.
        """

    def mark(self, text: str) -> None:
        """Have a word pinned to the next sample. No word is ever an order."""

    def order(self, text: str) -> None:
        """Tell a simulated hand what to do; a device that is none takes no notice.

        Never with text that a viewer or a file chose freely: see
        :mod:`firstcontact.device._twin_words`.
        """

    def close(self) -> None:
        """Stop the device and let go of it. Closing twice is fine."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *exception: object) -> None: ...


def drain(source: Source) -> list[Arrival]:
    """Close a source and return the samples that it received and that no reader took."""
    source.close()
    arrivals: list[Arrival] = []
    with suppress(InputError):  # the reader has it already, or ends anyway
        while new := source.read(0.0):
            arrivals += new
    return arrivals
