"""Models for the device, and the events of the chain in Python to compare with the device's."""

import json
from dataclasses import dataclass

import numpy as np

from firstcontact.chain import Chain, ChainEvent, EventKind, Flag, Image
from firstcontact.chain.constants import DetectorKind
from firstcontact.core import Block, Calibration, Finger, VibrationCalibration, fingertip_layout
from firstcontact.device.descriptor import DeviceContact, DeviceEstimate, DevicePrediction
from firstcontact.export.hand_image import HandImage
from random_chains import random_image

#: Noise floors of the twin's fingertips, V.
FLOORS = Calibration(tuple(VibrationCalibration(f, 0.0018) for f in Finger))


def model_image(seed: int, model: str = "network") -> HandImage:
    """Return the image of a random model with a detector that finds the twin's contacts."""
    digest = f"{seed:016x}"
    floors = [FLOORS.noise(f) or 0.0 for f in Finger]
    text = json.dumps({"model": digest, "floors": floors})
    image = random_image(seed, DetectorKind.THRESHOLD, model, floors=floors, text=text)
    return HandImage(image.data, digest)


def chain_events(
    image: HandImage, data: np.ndarray, hints: tuple[float, float, float] | None = None
) -> list[ChainEvent]:
    """Return the events of the chain in Python for samples of the device."""
    chain = Chain(Image(image.data), fingertip_layout(), FLOORS)
    if hints is not None:
        chain.hint(*hints)
    return chain.take(Block(data)) + chain.finish()


@dataclass(frozen=True)
class Predictions:
    """Contacts and estimates of a device or of the chain.

    Contacts have channel, sample, sample of the decision, and the flags of the first and of a
    withdrawn one. The key of an estimate is its contact and its number of samples. The value is
    the estimate, the ends of its interval, the out-of-range flag and the sample with which it was
    complete; zeros for the report that there is none.
    """

    contacts: list[tuple[int, int, int, bool, bool]]
    estimates: dict[tuple[int, int], tuple[float, float, float, bool, int]]


def of_chain(events: list[ChainEvent]) -> Predictions:
    """Return the predictions among the events of the chain."""
    withdrawn = EventKind.CONTACT_WITHDRAWN
    return Predictions(
        [
            (e.channel, e.sample, e.known, bool(e.flags & Flag.FIRST), e.kind == withdrawn)
            for e in events
            if e.kind in (EventKind.CONTACT_FOUND, withdrawn)
        ],
        {
            (e.sample, e.samples): (
                e.value, e.low, e.high, bool(e.flags & Flag.OUT_OF_RANGE), e.known,
            )
            for e in events
            if e.kind == EventKind.NOT_ESTIMATED
            or (e.kind == EventKind.ESTIMATED and not e.flags & Flag.FINAL)
        },
    )  # fmt: skip


def of_device(messages: list[DevicePrediction]) -> Predictions:
    """Return the predictions among the device's messages."""
    number = {finger: n for n, finger in enumerate(Finger)}
    return Predictions(
        [
            (number[m.finger], m.sample, m.decided, m.first, m.withdrawn)
            for m in messages
            if isinstance(m, DeviceContact)
        ],
        {
            (m.contact, m.samples): (m.value, m.low, m.high, m.out_of_range, m.decided)
            for m in messages
            if isinstance(m, DeviceEstimate)
        },
    )
