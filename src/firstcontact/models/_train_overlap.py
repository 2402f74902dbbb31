"""Digests of training pinches, and their overlap with evaluation data.

A digest is eight bytes of BLAKE2b of the piezo signals in V, as float32. Copies under other names,
and complete exports that are imported again, have the same digest. Resampled, filtered, scaled or
newly cut pinches have other digests, as have channels of other sensors.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import blake2b
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import LONGEST_NAME, Dataset, InputError, Pinch
from firstcontact.models._card import TrainingData
from firstcontact.models._training import full_specimen

Digests = NDArray[np.uint64]

#: Length of a digest, bytes. With 100,000 training and 100,000 test pinches, one run in a billion
#: has a false match.
SIZE = 8


def pinch_digests(pinches: Sequence[Pinch]) -> Digests:
    """Return the digest of each pinch, shape (pinches,)."""
    return np.array([_digest(pinch) for pinch in pinches], dtype=np.uint64)


def _digest(pinch: Pinch) -> int:
    with np.errstate(over="ignore"):
        volts = pinch.vibration().astype("<f4")
    volts += np.float32(0.0)  # -0 and 0 are the same voltage
    shape = np.array(volts.shape, dtype="<u8").tobytes()
    hashed = blake2b(shape + volts.tobytes(), digest_size=SIZE).digest()
    return int.from_bytes(hashed, "little")


def to_array(digests: Digests) -> NDArray[np.uint8]:
    """Return digests as an array of bytes for a file, ascending."""
    return np.unique(digests).astype("<u8").view(np.uint8)


def from_array(array: NDArray[Any] | None) -> Digests:
    """Return the digests in a file's array. Raise InputError if the array is invalid."""
    if array is None:
        return np.zeros(0, np.uint64)
    if array.dtype != np.uint8 or array.ndim != 1 or len(array) % SIZE:
        raise InputError(
            "the array 'pinches' does not hold digests of training pinches: train again"
        )
    return array.view("<u8").astype(np.uint64)


Mask = NDArray[np.bool_]
#: Titles of the groups of pinches that the model was, or may have been, trained on.
SEEN, NAMESAKES = "seen in training", "names as in the training, other samples"


@dataclass(frozen=True, slots=True, eq=False)
class TrainOverlap:
    """Masks of pinches by their relation to a model's training, shape (pinches,)."""

    seen: Mask
    namesakes: Mask
    same_session: Mask
    same_specimen: Mask
    new: Mask

    def groups(self) -> Mapping[str, Mask]:
        """Return each group by its title, unseen pinches first."""
        return {
            "not seen in training": self.new,
            "sessions of the training by name, other specimens": self.same_session,
            "specimens of the training, other sessions": self.same_specimen,
            NAMESAKES: self.namesakes,
            SEEN: self.seen,
        }

    def warnings(self, scored: NDArray[np.intp]) -> list[str]:
        """Return warnings about the pinches at these positions, one line each."""
        seen, namesakes = int(self.seen[scored].sum()), int(self.namesakes[scored].sum())
        apart = "scored separately and do not show the errors in use"
        lines = []
        if seen:
            lines.append(
                f"warning: {seen} pinches have the same samples as training pinches of the model: "
                f"they are {apart}"
            )
        if namesakes:
            lines.append(
                f"note: {namesakes} pinches have the session and specimen of training pinches, but "
                "other samples: they may be new, or training pinches that were resampled or cut "
                "again: they are scored separately"
            )
        return lines


def train_overlap(dataset: Dataset, trained_on: TrainingData, digests: Digests) -> TrainOverlap:
    """Group pinches by their relation to a model's training."""
    seen = np.isin(pinch_digests(dataset.pinches), digests)
    unseen = ~dataset.test & ~seen
    specimen = _same_specimen(dataset, trained_on) & unseen
    # Sessions of other sources may have the same names by chance.
    session = np.isin(dataset.sessions, trained_on.sessions) & (dataset.sessions != "") & unseen
    session &= trained_on.source == dataset.source
    is_unnamed = (dataset.specimens == "") & ("" in trained_on.specimens)
    namesakes = session & (specimen | is_unnamed)
    return TrainOverlap(
        seen,
        namesakes,
        session & ~namesakes,
        specimen & ~session,
        ~(seen | specimen | session),
    )


def _same_specimen(dataset: Dataset, trained_on: TrainingData) -> Mask:
    """Return a mask of the pinches whose specimen is one of the training."""
    full = [full_specimen(pinch.label)[:LONGEST_NAME] for pinch in dataset.pinches]
    is_same: Mask = np.isin(dataset.specimens, trained_on.specimens)
    if trained_on.objects:
        is_same &= np.isin(dataset.objects, ["", *trained_on.objects])
    is_same |= np.isin(full, trained_on.specimens)
    is_same &= dataset.specimens != ""
    return is_same
