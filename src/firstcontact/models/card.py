"""Card (``model.json``) of a model folder, and digests of its training pinches.

A digest is a hash of a pinch: eight bytes of BLAKE2b of its piezo signals in V, as float32. Equal
digests mean the same pinch. Copies under other names, and complete exports that are imported again,
have the same digest. Resampled, filtered, scaled or newly cut pinches have other digests, as have
channels of other sensors.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from hashlib import blake2b
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Dataset, ModelError, Pinch, Role
from firstcontact.core.physics import FLAT
from firstcontact.core.records import Count, Name, Notes
from firstcontact.core.weights import Rate, Sha256
from firstcontact.models.interval import Interval
from firstcontact.models.values import Task

#: Largest window that a model may require, in samples, and largest number of classes.
Samples = Annotated[int, msgspec.Meta(ge=1, le=1_000_000)]
Classes = Annotated[tuple[float, ...], msgspec.Meta(max_length=1000)]

#: Label that a model predicts: the name of a :class:`~firstcontact.core.Quantity`.
Target = Literal["shore_a", "modulus_mpa", "stiffness_n_per_mm", "hardness_rank"]


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainingData:
    """Description of the pinches that a model was trained on, as the model's card states it."""

    #: Source in the recordings' headers: "twin", "real" and so on.
    source: Name = ""
    pinches: Count = 0
    #: Distinct names. A specimen's name that several objects share is followed by object and level.
    sessions: tuple[Name, ...] = ()
    specimens: tuple[Name, ...] = ()
    target: Target = "shore_a"
    levels: tuple[float, ...] = ()
    #: Mean label of each named object; empty for ranks.
    objects: Mapping[Name, Annotated[float, msgspec.Meta(ge=0, le=1e6)]] = field(
        default_factory=dict
    )
    #: Unit of the vibration; "" if the card of an older model does not state it.
    unit: Name = ""
    #: Sentence on how the contacts were found.
    contacts: Notes = ""
    #: Sentence on the choice of the detector; "" without a choice.
    detector: Notes = ""
    seed: Count = 0
    #: Changes to the data, one sentence each.
    notes: tuple[Notes, ...] = ()
    #: Rate before resampling, Hz; None if the pinches were not resampled.
    recorded_rate_hz: Rate | None = None

    def with_shapes(self, data: Dataset) -> Dataset:
        """Return the pinches, in which the objects of the training count as flat blocks.

        An object whose label states a shape keeps that shape.
        """

        def shaped(pinch: Pinch) -> Pinch:
            label = pinch.label
            is_block = label.role is Role.TRAIN and label.object in self.objects
            if label.shape or not is_block:
                return pinch
            return replace(pinch, label=replace(label, shape=FLAT))

        return replace(data, pinches=tuple(map(shaped, data.pinches)))


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainingRecord:
    """Description of the training of one predictor, which people read but no code uses."""

    pinches: Count = 0
    #: Sentence on how the scored pinches were held out.
    split: Notes = ""
    scores: Mapping[Name, Any] = field(default_factory=dict)
    #: Calibration and coverage of the interval, or ``none`` and the reason why there is none.
    calibration: Mapping[Name, Any] = field(default_factory=dict)
    #: Hyper-parameters and scaling that the training chose.
    training: Mapping[Name, Any] = field(default_factory=dict)


class PredictorCard(msgspec.Struct, frozen=True, kw_only=True, tag_field="takes"):
    """Entry of a card for one predictor: kind of its model, sampling rate, and training."""

    kind: Name
    rate_hz: Rate
    record: TrainingRecord


class WindowCard(PredictorCard, frozen=True, kw_only=True, tag="window"):
    """Entry of a card for a window model: also the shape of its windows, classes, and interval."""

    task: Task
    samples: Samples
    channels: Annotated[int, msgspec.Meta(ge=1, le=2)]
    channel_order: tuple[Name, ...]
    classes: Classes = ()
    interval: Interval | None = None


class AnytimeCard(PredictorCard, frozen=True, kw_only=True, tag="contact"):
    """Entry of a card for an any-time model: also the nominal coverage of its intervals."""

    level: Annotated[float, msgspec.Meta(gt=0, lt=1)] | None = None


class ModelCard(msgspec.Struct, frozen=True, kw_only=True):
    """Content of ``model.json``, the card that describes a model folder."""

    sha256: Sha256 | None = None
    trained_on: TrainingData = TrainingData()
    predictors: Annotated[tuple[WindowCard | AnytimeCard, ...], msgspec.Meta(max_length=100)]
    detector: Sha256 | None = None
    versions: Mapping[Name, Name] = msgspec.field(default_factory=dict)


Digests = NDArray[np.uint64]

#: Length of a digest, bytes. With 100,000 training and 100,000 test pinches, one run in a billion
#: has a false match.
SIZE = 8


def pinch_digests(pinches: Sequence[Pinch]) -> Digests:
    """Return the digest (hash) of each pinch, shape (pinches,)."""
    return np.array([_digest(pinch) for pinch in pinches], dtype=np.uint64)


def _digest(pinch: Pinch) -> int:
    with np.errstate(over="ignore"):
        volts = pinch.vibration().astype("<f4")
    volts += np.float32(0.0)  # -0 and 0 are the same voltage
    shape = np.array(volts.shape, dtype="<u8").tobytes()
    hashed = blake2b(shape + volts.tobytes(), digest_size=SIZE).digest()
    return int.from_bytes(hashed, "little")


def to_array(digests: Digests) -> NDArray[np.uint8]:
    """Return digests as bytes in ascending order, as the weights file stores them."""
    return np.unique(digests).astype("<u8").view(np.uint8)


def from_array(array: NDArray[Any] | None) -> Digests:
    """Return the digests that :func:`to_array` stored. Raise ModelError if the array is invalid."""
    if array is None:
        return np.zeros(0, np.uint64)
    if array.dtype != np.uint8 or array.ndim != 1 or len(array) % SIZE:
        raise ModelError(
            "the array 'pinches' does not hold digests of training pinches: train again"
        )
    return array.view("<u8").astype(np.uint64)
