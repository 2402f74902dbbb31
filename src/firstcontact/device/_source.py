"""Interface of all sample sources: serial devices, the twin, replayed recordings."""

from __future__ import annotations

import json
import threading
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any, Protocol, Self

from firstcontact.core import Block, InputError, Layout, Name, VibrationSensor, read_record
from firstcontact.device._device_predictions import DevicePrediction, DevicePredictor, ModelSlot
from firstcontact.recording import SOURCES, Marker, PinchMark

_FLASH = "flash the firmware that belongs to this version of firstcontact"


@dataclass(frozen=True, slots=True)
class _DescriptorJson:
    """JSON form of a descriptor, as a device sends it. All fields are required."""

    firmware: Name
    sensor: Name
    hand: Name
    source: Name
    layout: Layout
    answers: DevicePredictor | None = None
    models: ModelSlot | None = None
    paced: bool = True


def layout_to_send(layout: Layout) -> dict[str, Any]:
    """Return a layout as JSON in the form of protocol version 1.

    In that form vibration channels have the kind ``piezo`` and share one smoothing factor. A layout
    with other sensors is returned in the form that recordings use. Readers understand both forms.
    """
    alphas = {c.smoothing_alpha for c in layout.vibration}
    is_version_1 = all(
        c.sensor is VibrationSensor.PIEZO and c.finger is not None for c in layout.vibration
    )
    if not is_version_1 or layout.groups or len(alphas) != 1 or layout.width > len(layout.channels):
        return layout.to_json()
    names = ("name", "kind", "finger", "unit", "scale", "offset", "taxel")
    channels = [{name: getattr(c, name) for name in names} for c in layout.channels]
    for sent, channel in zip(channels, layout.channels, strict=True):
        sent["kind"] = channel.sensor or channel.kind
    return {"channels": channels, "rate": layout.rate, "smoothing_alpha": alphas.pop()}


@dataclass(frozen=True, slots=True)
class Descriptor:
    """Metadata of a source. An empty text means unknown.

    Parameters
    ----------
    layout
        Columns of a sample, and the sample rate.
    firmware, sensor, hand
        Names of the sender's firmware, sensor and hand.
    source
        "real", "twin", "synthetic" or "unknown", as in the header of a recording.
    dtype
        Data type of the samples. A device on the wire sends int16.
    delay
        Delay of the source's own filter, s.
    predictor
        Model that predicts on the device itself; None if there is none.
    model_slot
        Models that the device accepts; None if it accepts none.
    paced
        True if the device sends its samples in real time.
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
        """Return the descriptor as JSON, as it goes over the wire."""
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
        """Create a descriptor from JSON, the inverse of :meth:`to_text`.

        Raises
        ------
        InputError
            The text is not JSON, a field is missing or out of bounds, or the layout has no
            fingertips.
        """
        fields = read_record(text.encode(), _DescriptorJson, "the device's descriptor", _FLASH)
        fault = fields.layout.fault
        if not fault and fields.source not in SOURCES:
            fault = f"the source {fields.source!r}, not one of {', '.join(SOURCES)}"
        if fault:
            raise InputError(f"the device's descriptor has {fault}: {_FLASH}")
        return cls(
            fields.layout,
            fields.firmware,
            fields.sensor,
            fields.hand,
            fields.source,
            predictor=fields.answers,
            model_slot=fields.models,
            paced=fields.paced,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Arrival:
    """Consecutive samples with the time at which the host received them.

    Parameters
    ----------
    block
        Samples, numbered with 64 bits.
    host
        Arrival time of the last byte by ``time.monotonic()``, s.
    markers
        Markers of these samples. A marker whose sample was lost comes with the newest unread
        samples, or with an empty block if there are none.
    pinches
        Marks of the pinches that end in these samples. Only replayed recordings have them.
    predictions
        Contacts and estimates that the device predicted by itself, in the order received. They can
        refer to the arrival's samples, to earlier samples, or to samples that have not arrived yet.
    """

    block: Block
    host: float
    markers: tuple[Marker, ...] = ()
    pinches: tuple[PinchMark, ...] = ()
    predictions: tuple[DevicePrediction, ...] = ()


@dataclass(frozen=True, slots=True)
class Health:
    """State and counts of a source since it was opened.

    Parameters
    ----------
    connected
        True if the device is connected now.
    epoch
        Epoch of the newest sample.
    samples
        Number of received samples.
    lost_samples
        Number of samples missing in the device's count, for any reason. The count is exact between
        two received samples and before a ``stopped`` frame.
    overflow_samples
        Number of lost samples that the device itself dropped, by its report.
    unusable_samples
        Number of lost samples with a value that was NaN, infinite or beyond 32-bit integers, or
        with a time stamp that jumps.
    lost_frames
        Number of frames missing in the device's count.
    bad_frames
        Number of damaged frames. Each is also counted as lost.
    doubled_frames
        Number of ignored frames that were repeated or out of order.
    late_answers
        Number of predictions that the device skipped because the next one was due.
    unheard_samples
        Number of samples that the device sent but its own model missed.
    reconnects
        Number of reconnections. Each begins an epoch.
    host_rate
        Samples per second of the host's clock over the last epoch, Hz; 0 until measured.
    losses_known
        True if the device counts its samples, so that losses are detected.
    ended
        True if no more samples can come, for example after the end of a recording.
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
        """Text with the number of lost samples."""
        unknown = "" if self.losses_known else " or more (the device does not count its samples)"
        return f"{self.lost_samples}{unknown}"

    @property
    def unusable(self) -> str:
        """Text with the number of unusable samples."""
        count = self.unusable_samples
        return f"{count} NaN, infinite, out of range, or with a time stamp that jumps"


class Source(Protocol):
    """Source of samples. It delivers each sample once, in order.

    ``with`` opens the source. A thread receives the samples, so a slow reader loses none. Call
    :meth:`read` from one thread only.
    """

    @property
    def name(self) -> str:
        """Name shown to users: the port, "twin" or the file."""

    @property
    def descriptor(self) -> Descriptor:
        """Metadata of the source, available once it is open."""

    @property
    def health(self) -> Health:
        """Current state and counts. They can be read from any thread."""

    @property
    def ended(self) -> bool:
        """Return True if no more samples come and all samples and errors were delivered."""

    def read(self, timeout: float, least: int = 1) -> list[Arrival]:
        """Return all samples received since the last call. Wait up to ``timeout`` s for more.

        Parameters
        ----------
        timeout
            Longest wait, s. After it, the method returns the samples received so far, if any.
        least
            Number of samples to wait for. The wait ends as soon as they have arrived.

        Raises
        ------
        InputError
            Another device (with another layout) is now on the port, or the port is permanently
            lost. Or the source is not open, or closed and an earlier read returned nothing, or the
            timeout is NaN or too long.
        """

    def mark(self, text: str) -> None:
        """Attach a marker to the next sample. A marker is never an order."""

    def order(self, text: str) -> None:
        """Send an order to a simulated hand. Other devices ignore it.

        Never send text that a viewer or a file chose freely: see
        :mod:`firstcontact.device._twin_words`.
        """

    def close(self) -> None:
        """Stop the device and release it. Closing twice is fine."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *exception: object) -> None: ...


def check_readable(source: Source, timeout: float, *, is_drained: bool) -> None:
    """Refuse a read that would give nothing for ever: see :meth:`Source.read`."""
    source.descriptor  # noqa: B018  # refuses if the source is not open
    if is_drained:
        raise InputError(f"{source.name} is closed: open it again")
    if not timeout <= threading.TIMEOUT_MAX:
        raise InputError(
            f"it is {timeout:g} s: give at most {threading.TIMEOUT_MAX:.3g} s", parameter="timeout"
        )


def require_source(source: object) -> None:
    """Raise InputError if the value is no source, such as the name of a device."""
    if not hasattr(type(source), "descriptor"):
        raise InputError(
            f"the source must be an open one, not a {type(source).__name__}: make one with "
            "open(device)",
            parameter="source",
        )


def drain(source: Source) -> list[Arrival]:
    """Close a source and return the received samples that were not read yet."""
    source.close()
    arrivals: list[Arrival] = []
    with suppress(InputError):  # the reader has raised it already, or is ending
        while new := source.read(0.0):
            arrivals += new
    return arrivals
