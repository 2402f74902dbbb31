"""What a device that answers by itself tells: contacts and estimates, as frames hold them."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Annotated

from msgspec import Meta

from firstcontact.core import Finger, Name
from firstcontact.device._protocol import FrameError

_CONTACT = struct.Struct("<IIBB")
_ESTIMATE = struct.Struct("<IIHBBfffI")
#: Flags of an estimate.
REFUSES, STRANGE = 1, 2


@dataclass(frozen=True, slots=True)
class DevicePredictor:
    """What answers on a device, as its descriptor says.

    Parameters
    ----------
    model
        Digest of the model, 16 hexadecimal digits.
    detector, anytime
        Names of what it is made of.
    floors
        Noise of each finger above which it hears a motor, V; 0 where it was not told.
    """

    model: Annotated[str, Meta(pattern="^[0-9a-f]{16}$")]
    detector: Name = ""
    anytime: Name = ""
    floors: Annotated[tuple[Annotated[float, Meta(ge=0.0, le=1e9)], ...], Meta(max_length=2)] = ()


@dataclass(frozen=True, slots=True)
class ModelSlot:
    """What models a device takes, as its descriptor says.

    Parameters
    ----------
    format, sizes
        Of the images that it reads, and CRC of the sizes that its kernels have.
    room
        Longest image, bytes.
    fault
        Why the newest model that it keeps does not answer; "" where it does, or none is kept.
    """

    format: Annotated[int, Meta(ge=0, lt=2**32)]
    sizes: Annotated[int, Meta(ge=0, lt=2**32)]
    room: Annotated[int, Meta(ge=0, lt=2**32)]
    fault: Name = ""


def skipped_model(models: ModelSlot, answers: bool) -> str:
    """What a device says of a newest model that does not answer."""
    older = "the one before it answers" if answers else "none answers"
    return (
        f"the device passes over the newest model that it keeps ({models.fault}), and {older}: "
        "bring one onto it with `firstcontact flash-model`"
    )


@dataclass(frozen=True, slots=True)
class DeviceContact:
    """A contact that the device found.

    Parameters
    ----------
    finger
        Whose.
    sample, decided
        At which it began, and after which the device knew it; 64 bits.
    first
        Whether it is the closing's first.
    epoch
        Of the samples.
    """

    finger: Finger
    sample: int
    decided: int
    first: bool
    epoch: int


@dataclass(frozen=True, slots=True)
class DeviceEstimate:
    """An answer of the device.

    Parameters
    ----------
    finger, contact
        Of the contact that it is about, and the sample at which that began.
    samples
        After the contact that it was made from.
    decided
        Sample after which the device made it.
    value, low, high
        Shore A and the interval's ends.
    refused
        Whether it is none: the signal cannot be used.
    out_of_range
        Whether the contact is like nothing that was learned from.
    compute_time
        What making it took on the device, s; 0 where the device does not measure that.
    epoch
        Of the samples.
    """

    finger: Finger
    contact: int
    samples: int
    decided: int
    value: float
    low: float
    high: float
    refused: bool
    out_of_range: bool
    compute_time: float
    epoch: int

    def after(self, rate: float) -> float:
        """From the contact to the answer, s; rate in Hz."""
        return (self.decided - self.contact) / rate + self.compute_time


DevicePrediction = DeviceContact | DeviceEstimate


def contact_payload(finger: Finger, sample: int, known: int, first: bool) -> bytes:
    """Payload of a contact frame."""
    return _CONTACT.pack(sample & 0xFFFFFFFF, known & 0xFFFFFFFF, list(Finger).index(finger), first)


def read_contact(payload: bytes, epoch: int) -> DeviceContact:
    """A contact frame's payload, sample numbers as sent (32 bits); FrameError when damaged."""
    if len(payload) != _CONTACT.size:
        raise FrameError("a contact frame has the wrong length")
    sample, known, finger, first = _CONTACT.unpack(payload)
    return DeviceContact(_finger(finger), sample, known, bool(first), epoch)


def estimate_payload(told: DeviceEstimate) -> bytes:
    """Payload of an estimate frame."""
    return _ESTIMATE.pack(
        told.contact & 0xFFFFFFFF,
        told.decided & 0xFFFFFFFF,
        told.samples,
        list(Finger).index(told.finger),
        told.refused * REFUSES | told.out_of_range * STRANGE,
        told.value,
        told.low,
        told.high,
        round(told.compute_time * 1e9),
    )


def read_estimate(payload: bytes, epoch: int) -> DeviceEstimate:
    """An estimate frame's payload, sample numbers as sent (32 bits); FrameError when damaged."""
    if len(payload) != _ESTIMATE.size:
        raise FrameError("an estimate frame has the wrong length")
    contact, known, samples, finger, flags, value, low, high, took = _ESTIMATE.unpack(payload)
    if not 0.0 <= low <= value <= high <= 100.0:  # nor where one is no number
        raise FrameError("an estimate is no Shore A inside its interval")
    return DeviceEstimate(
        _finger(finger),
        contact,
        samples,
        known,
        value,
        low,
        high,
        bool(flags & REFUSES),
        bool(flags & STRANGE),
        took * 1e-9,
        epoch,
    )


def check_place(answer: DevicePrediction, newest: int, farthest: int) -> None:
    """Raise FrameError where a contact or an estimate cannot be of a device's samples.

    Parameters
    ----------
    answer
        Contact or estimate with sample numbers of 64 bits.
    newest
        Number of the sample that comes next.
    farthest
        Largest distance from it, samples.
    """
    contact = answer.sample if isinstance(answer, DeviceContact) else answer.contact
    if not max(0, answer.decided - farthest) <= contact <= answer.decided:
        raise FrameError("a contact is not in the samples before it was known")
    if abs(answer.decided - newest) > farthest:
        raise FrameError("a contact is known far from the samples that come")
    if isinstance(answer, DeviceEstimate) and answer.samples > answer.decided - contact + 1:
        raise FrameError("an estimate is from samples after it was made")


def _finger(number: int) -> Finger:
    fingers = list(Finger)
    if number >= len(fingers):
        raise FrameError(f"there is no finger {number}")
    return fingers[number]
