"""Payloads of a device's predictions, which only devices write, and of its samples, for tests."""

import struct
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Finger
from firstcontact.device.descriptor import OUT_OF_RANGE, REFUSED, DeviceEstimate
from firstcontact.device.protocol import samples_head

MASK = 0xFFFFFFFF


def contact_payload(finger: Finger, sample: int, decided: int, first: bool) -> bytes:
    return struct.pack("<IIBB", sample & MASK, decided & MASK, list(Finger).index(finger), first)


def estimate_payload(e: DeviceEstimate) -> bytes:
    flags = e.refused * REFUSED | e.out_of_range * OUT_OF_RANGE | e.reason << 4
    places = e.contact & MASK, e.decided & MASK, e.samples, list(Finger).index(e.finger)
    numbers = e.value, e.low, e.high, round(e.compute_time * 1e9)
    return struct.pack("<IIHBBfffI", *places, flags, *numbers)


def late_payload(skipped: int, unheard: int) -> bytes:
    return struct.pack("<II", skipped & MASK, unheard & MASK)


class SamplesFrame(NamedTuple):
    """Payload of a samples frame. ``data`` has shape (n, channels), int16."""

    first_sample: int
    overflow: int
    data: NDArray[np.int16]


def read_samples(payload: bytes, channels: int) -> SamplesFrame:
    first, overflow, n, data = samples_head(payload, channels)
    return SamplesFrame(first, overflow, np.frombuffer(data, dtype="<i2").reshape(n, channels))
