"""Descriptor of a device (its layout, names and model), and predictions made on the device."""

from __future__ import annotations

import json
import struct
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from typing import Annotated, Any, Self

from msgspec import Meta

from firstcontact.core import DeviceError, Finger, InputError, Layout, VibrationSensor
from firstcontact.core.records import Name, read_record
from firstcontact.device.protocol import VERSION, FrameError, FrameType, read_descriptor, unpack
from firstcontact.recording import Header
from firstcontact.recording.messages import SOURCES

_CONTACT = struct.Struct("<IIBB")
_ESTIMATE = struct.Struct("<IIHBBfffI")
#: Flags of an estimate, and the position of the reason why there is none.
REFUSED, OUT_OF_RANGE = 1, 2
_REASON_SHIFT = 4
_FLASH = "flash the firmware that belongs to this version of firstcontact"


@dataclass(frozen=True, slots=True)
class DevicePredictor:
    """Description of the model that runs on a device, from the device's descriptor."""

    #: Digest of the model.
    model: Annotated[str, Meta(pattern="^[0-9a-f]{16}$")]
    detector: Name = ""
    #: Name of the model that predicts at any time after a contact.
    anytime: Name = ""
    #: Noise level of each finger above which the motor counts as audible, V; 0 if not set.
    floors: Annotated[tuple[Annotated[float, Meta(ge=0.0, le=1e9)], ...], Meta(max_length=2)] = ()


@dataclass(frozen=True, slots=True)
class ModelSlot:
    """Description of a device's memory for a model, from the device's descriptor.

    ``format`` is the version of model images that the firmware reads, and ``room`` the size of the
    memory, bytes. ``fault`` says why the stored model cannot be used; "" if it can.
    """

    format: Annotated[int, Meta(ge=0, lt=2**32)]
    room: Annotated[int, Meta(ge=0, lt=2**32)]
    fault: Name = ""


def skipped_model(models: ModelSlot, has_predictor: bool) -> str:
    fallback = "runs the one before it" if has_predictor else "runs none"
    return (
        f"the device cannot use the newest model stored on it ({models.fault}) and {fallback}: "
        "store a model on it with `firstcontact flash-model`"
    )


@dataclass(frozen=True, slots=True)
class _DescriptorJson:
    """Descriptor as a device sends it in JSON. The fields have the names in the JSON text."""

    firmware: Name
    sensor: Name
    hand: Name
    source: Name
    layout: Layout
    answers: DevicePredictor | None = None
    models: ModelSlot | None = None
    paced: bool = True


def layout_to_send(layout: Layout) -> dict[str, Any]:
    """Return a layout as a dict for a descriptor's JSON.

    If version 1 of the layout's format can express the layout, that version is used.
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
    """Metadata of a source of samples, as the device states them. "" means unknown.

    Parameters
    ----------
    layout
        Columns of a sample (name, finger, unit, scale), and the sampling rate, Hz.
    firmware, sensor, hand
        Names of the firmware, of the sensor, and of the hand that carries the sensor.
    source
        Origin of the samples: "real", "twin" (simulated hand), "synthetic" or "unknown".
    dtype
        NumPy data type of the samples. Fingertips on a serial port send "int16".
    delay
        Time by which the source's own filter delays each sample, s.
    predictor, model_slot
        Model that runs on the device itself, and the device's memory for models; None if it has
        none.
    paced
        True if samples arrive at the sampling rate, False if faster or slower (fast replay).
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

    def header(self, **fields: Any) -> Header:
        """Return a header for a new recording of this source, created now.

        ``fields`` are further fields of :class:`~firstcontact.recording.Header`, or replace some.
        """
        names = ("layout", "source", "dtype", "sensor", "hand", "firmware")
        values = {name: getattr(self, name) for name in names}
        created = datetime.now(UTC).isoformat(timespec="seconds")
        return Header(**{**values, "created": created, **fields})

    def to_text(self) -> str:
        """Return the descriptor as JSON text, in the form that a device sends."""
        names = ("firmware", "sensor", "hand", "source")
        tree: dict[str, Any] = {name: getattr(self, name) for name in names}
        tree["layout"] = layout_to_send(self.layout)
        if self.predictor is not None:
            tree["answers"] = asdict(self.predictor)
        if self.model_slot is not None:
            tree["models"] = asdict(self.model_slot)
        if not self.paced:
            tree["paced"] = False
        return json.dumps(tree, separators=(",", ":"), ensure_ascii=False)

    @classmethod
    def from_text(cls, text: str) -> Self:
        """Parse a descriptor from a device's JSON text. Raise DeviceError if a field is wrong."""
        fields = read_record(
            text.encode(), _DescriptorJson, "the device's descriptor", _FLASH, error=DeviceError
        )
        fault = fields.layout.why_unusable
        if not fault and fields.source not in SOURCES:
            fault = f"the source {fields.source!r}, not one of {', '.join(SOURCES)}"
        if fault:
            raise DeviceError(f"the device's descriptor has {fault}: {_FLASH}")
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


def read_greeting(payload: bytes) -> tuple[int, Descriptor]:
    version, boot, text = read_descriptor(payload)
    if version != VERSION:
        raise DeviceError(_version_mismatch(version))
    return boot, Descriptor.from_text(text)


def refusal(payload: bytes) -> InputError:
    if payload and payload[0] != VERSION:
        return DeviceError(_version_mismatch(payload[0]))
    reason = payload[1:].decode(errors="replace")
    return DeviceError(f"the device refuses the connection ({reason}): {_FLASH}")


def _version_mismatch(version: int) -> str:
    return (
        f"the device speaks version {version} of the protocol and this program version {VERSION}: "
        f"{_FLASH}"
    )


@dataclass(frozen=True, slots=True)
class DeviceContact:
    finger: Finger
    #: Samples at which the contact began, and after which the device detected it.
    sample: int
    decided: int
    first: bool
    epoch: int
    #: True if the device withdraws this contact and its estimates.
    withdrawn: bool = False


@dataclass(frozen=True, slots=True)
class DeviceEstimate:
    finger: Finger
    #: Sample at which the contact began, and number of samples after it that the model used.
    contact: int
    samples: int
    #: Sample after which the device predicted.
    decided: int
    #: Shore A, and the ends of the interval.
    value: float
    low: float
    high: float
    #: True if there is no estimate; :class:`firstcontact.chain.Reason` says why.
    refused: bool
    out_of_range: bool
    #: Computing time on the device, s; 0 if not measured.
    compute_time: float
    epoch: int
    reason: int = 0


DevicePrediction = DeviceContact | DeviceEstimate


def read_contact(payload: bytes, epoch: int, *, withdrawn: bool = False) -> DeviceContact:
    sample, decided, finger, first = unpack(_CONTACT, payload, FrameType.CONTACT)
    return DeviceContact(_finger(finger), sample, decided, bool(first), epoch, withdrawn)


def read_estimate(payload: bytes, epoch: int) -> DeviceEstimate:
    contact, decided, samples, finger, flags, value, low, high, nanoseconds = unpack(
        _ESTIMATE, payload, FrameType.ESTIMATE
    )
    if not 0.0 <= low <= value <= high <= 100.0:  # False for NaN too
        raise FrameError(
            f"the device sent the estimate {value:g} with the interval {low:g} to {high:g}: the "
            "value must be inside the interval, and both from 0 to 100"
        )
    return DeviceEstimate(
        _finger(finger),
        contact,
        samples,
        decided,
        value,
        low,
        high,
        bool(flags & REFUSED),
        bool(flags & OUT_OF_RANGE),
        nanoseconds * 1e-9,
        epoch,
        flags >> _REASON_SHIFT,
    )


def check_place(prediction: DevicePrediction, newest: int, farthest: int) -> None:
    """Raise FrameError if the sample numbers of a device's contact or estimate are impossible.

    They must lie within ``farthest`` samples of each other and of ``newest``, the newest sample.
    """
    if isinstance(prediction, DeviceContact):
        contact, samples = prediction.sample, 0
    else:
        contact, samples = prediction.contact, prediction.samples
    decided = prediction.decided
    if (
        not max(0, decided - farthest) <= contact <= decided
        or abs(decided - newest) > farthest
        or samples > decided - contact + 1
    ):
        raise FrameError("a device's contact or estimate has impossible sample numbers")


def _finger(number: int) -> Finger:
    fingers = list(Finger)
    if number >= len(fingers):
        raise FrameError(
            f"the device names finger {number}, but only 0 and 1 exist: check its firmware"
        )
    return fingers[number]
