"""Contacts and estimates of a device that runs a model itself, and the frames that carry them."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from firstcontact.core import Finger
from firstcontact.device._protocol import FrameError, FrameType, unpack

_CONTACT = struct.Struct("<IIBB")
_ESTIMATE = struct.Struct("<IIHBBfffI")
#: Flags of an estimate, and the position of the reason why there is none.
REFUSED, OUT_OF_RANGE = 1, 2
_REASON_SHIFT = 4


@dataclass(frozen=True, slots=True)
class DeviceContact:
    """Contact that the device detected.

    Parameters
    ----------
    finger
        Finger that touched.
    sample, decided
        Numbers of the sample at which the contact began, and of the sample after which the device
        detected it.
    first
        True for the first contact of a closing.
    epoch
        Epoch of the samples.
    withdrawn
        True if the device withdraws this contact and its estimates: it was none.
    """

    finger: Finger
    sample: int
    decided: int
    first: bool
    epoch: int
    withdrawn: bool = False


@dataclass(frozen=True, slots=True)
class DeviceEstimate:
    """Stiffness that the device predicted.

    Parameters
    ----------
    finger, contact
        Finger of the contact, and the sample at which the contact began.
    samples
        Number of samples after the contact that the model used.
    decided
        Sample after which the device predicted.
    value, low, high
        Shore A, and the ends of the interval.
    refused, reason
        True if there is no estimate, and the reason, a :class:`firstcontact.chain.Reason`.
    out_of_range
        True if the contact is unlike the training data.
    compute_time
        Computing time on the device, s; 0 if the device does not measure it.
    epoch
        Epoch of the samples.
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
    reason: int = 0

    def delay(self, rate: float) -> float:
        """Return the time from the contact to the estimate, s. ``rate`` is in Hz."""
        return (self.decided - self.contact) / rate + self.compute_time


DevicePrediction = DeviceContact | DeviceEstimate


def contact_payload(finger: Finger, sample: int, decided: int, first: bool) -> bytes:
    """Return the payload of a contact frame."""
    numbers = sample & 0xFFFFFFFF, decided & 0xFFFFFFFF
    return _CONTACT.pack(*numbers, list(Finger).index(finger), first)


def read_contact(payload: bytes, epoch: int, *, withdrawn: bool = False) -> DeviceContact:
    """Return the contact in the payload of a frame that reports or withdraws it."""
    sample, decided, finger, first = unpack(_CONTACT, payload, FrameType.CONTACT)
    return DeviceContact(_finger(finger), sample, decided, bool(first), epoch, withdrawn)


def estimate_payload(estimate: DeviceEstimate) -> bytes:
    """Return the payload of an estimate frame."""
    return _ESTIMATE.pack(
        estimate.contact & 0xFFFFFFFF,
        estimate.decided & 0xFFFFFFFF,
        estimate.samples,
        list(Finger).index(estimate.finger),
        estimate.refused * REFUSED
        | estimate.out_of_range * OUT_OF_RANGE
        | estimate.reason << _REASON_SHIFT,
        estimate.value,
        estimate.low,
        estimate.high,
        round(estimate.compute_time * 1e9),
    )


def read_estimate(payload: bytes, epoch: int) -> DeviceEstimate:
    """Return the estimate in the payload of an estimate frame."""
    contact, decided, samples, finger, flags, value, low, high, nanoseconds = unpack(
        _ESTIMATE, payload, FrameType.ESTIMATE
    )
    if not 0.0 <= low <= value <= high <= 100.0:  # False for NaN too
        raise FrameError("an estimate is not a Shore A value inside its interval")
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
    """Raise FrameError if a contact or estimate cannot belong to the device's samples."""
    contact = prediction.sample if isinstance(prediction, DeviceContact) else prediction.contact
    if not max(0, prediction.decided - farthest) <= contact <= prediction.decided:
        raise FrameError(
            "a device's contact has a sample number after that of its detection, or too far "
            "before it"
        )
    if abs(prediction.decided - newest) > farthest:
        raise FrameError(
            "a device's contact was detected at a sample number far from those that arrive now"
        )
    if (
        isinstance(prediction, DeviceEstimate)
        and prediction.samples > prediction.decided - contact + 1
    ):
        raise FrameError(
            "a device's estimate uses samples that come after the sample at which it was made"
        )


def _finger(number: int) -> Finger:
    fingers = list(Finger)
    if number >= len(fingers):
        raise FrameError(f"a device's contact is of finger {number}, which does not exist")
    return fingers[number]
