"""What a contact detector is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact.closing_start import closing_start
from firstcontact.core.block import Block
from firstcontact.core.layout import Finger, Layout
from firstcontact.core.pinch import Contact, Dataset, Pinch


@dataclass(frozen=True, slots=True, eq=False)
class Verdicts:
    """What a detector says of each window, whatever was detected before.

    Parameters
    ----------
    ends
        Number of the last sample of each window, shape (windows,).
    fired
        Whether the window shows a contact that began in its newest part,
        shape (windows, fingers with a piezo).
    onsets
        Sample at which that contact began, -1 where nothing fired, same shape.
    """

    ends: NDArray[np.int64]
    fired: NDArray[np.bool_]
    onsets: NDArray[np.int64]


def latch(verdicts: Verdicts, fingers: Sequence[Finger], latched: set[Finger]) -> list[Contact]:
    """The first firing of each finger that is not latched yet, and latch it.

    Parameters
    ----------
    verdicts
        Windows in the order of time.
    fingers
        Fingers of their columns.
    latched
        Fingers that have touched already; those found are added.

    Returns
    -------
    list of Contact
        In the order of the windows; within one, the earlier onset first.
    """
    contacts: list[Contact] = []
    for row in np.flatnonzero(verdicts.fired.any(axis=1)):
        end = int(verdicts.ends[row])
        columns = zip(fingers, verdicts.fired[row], verdicts.onsets[row], strict=True)
        found = [Contact(f, int(o), end) for f, fired, o in columns if fired and f not in latched]
        latched.update(contact.finger for contact in found)
        contacts += sorted(found, key=lambda contact: contact.sample)
    return contacts


class Detector(Protocol):
    """Finds the contacts in a stream of blocks.

    The same blocks, split anywhere, give the same contacts: offline is live
    with the blocks already there.
    """

    @property
    def name(self) -> str:
        """Under which it is registered and reported."""

    @property
    def duration(self) -> float:
        """Length of a window, s."""

    @property
    def step(self) -> float:
        """New part of a window, s: one verdict every so often."""

    def fit(self, dataset: Dataset) -> Self:
        """Learn from pinches whose contacts are known."""

    def start(self, layout: Layout) -> None:
        """Begin a new closing: forget the stream and release all fingers."""

    def judge(self, block: Block) -> Verdicts:
        """Verdicts on the windows that this block completes.

        A block that does not follow the one before starts a new steady state;
        no window is ever made across a gap, an epoch or a sample that is not
        finite.
        """

    def update(self, block: Block) -> list[Contact]:
        """Contacts that this block makes known, each finger once per closing."""


def detect(detector: Detector, pinch: Pinch) -> list[Contact]:
    """All contacts in a pinch from where its closing starts, as a stream would have given them.

    What a pinch does not say of its start by itself, the pinches recorded with it may: see
    :func:`firstcontact.contact.closing_start.closings`.
    """
    start = closing_start(pinch).sample
    detector.start(pinch.layout)
    return detector.update(Block(pinch.data[start - pinch.first_sample :], start))
