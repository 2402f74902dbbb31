"""What a contact detector is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact._closing_start import closing_start
from firstcontact.core import Block, Contact, Dataset, Finger, Layout, Pinch


@dataclass(frozen=True, slots=True, eq=False)
class WindowDecisions:
    """What a detector says of each window, whatever was detected before.

    Parameters
    ----------
    ends
        Number of the last sample of each window, shape (windows,).
    fired
        Whether the window shows a contact that began in its newest part,
        shape (windows, vibration channels).
    onsets
        Sample at which that contact began, -1 where nothing fired, same shape.
    """

    ends: NDArray[np.int64]
    fired: NDArray[np.bool_]
    onsets: NDArray[np.int64]


def latch(
    verdicts: WindowDecisions, fingers: Sequence[Finger | None], latched: set[Finger | None]
) -> list[Contact]:
    """The first firing of each finger that is not latched yet, and latch it.

    Parameters
    ----------
    verdicts
        Windows in the order of time.
    fingers
        Fingers of their columns; None is the sensor that belongs to no finger.
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
    with the blocks already there. Most are a
    :class:`firstcontact.contact._stream.WindowDetector`, which has everything but the
    judgement itself.
    """

    #: On the command line, in files and in results.
    name: ClassVar[str]
    #: As people read it, and its colour in figures.
    title: ClassVar[str]
    colour: ClassVar[str]
    #: Whether :meth:`fit` learns anything.
    learns: ClassVar[bool]
    #: Length of a window, s, and of its new part: one verdict every so often.
    duration: ClassVar[float]
    step: ClassVar[float]

    @property
    def rate(self) -> float | None:
        """The sampling rate that it takes, Hz; None where it takes any."""

    def fit(self, dataset: Dataset, early: float = 0.0) -> Self:
        """Learn from pinches whose contacts are known.

        Parameters
        ----------
        dataset
            The pinches.
        early
            A contact may be up to this much earlier than its label, s.

        Raises
        ------
        InputError
            There is too little to learn from.
        """

    def start(self, layout: Layout) -> None:
        """Begin a new closing: forget the stream and release all fingers."""

    def judge(self, block: Block) -> WindowDecisions:
        """Decisions on the windows that this block completes.

        A block that does not follow the one before starts a new steady state;
        no window is ever made across a gap, an epoch or a sample that is not
        finite.
        """

    def update(self, block: Block) -> list[Contact]:
        """Contacts that this block makes known, each finger once per closing."""

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        """Everything that was learned or chosen, to be saved; InputError when nothing was yet."""

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """The inverse of :meth:`to_arrays`; InputError if they do not fit together."""


def detect(detector: Detector, pinch: Pinch) -> list[Contact]:
    """All contacts in a pinch from where its closing starts, as a stream would have given them.

    What a pinch does not say of its start by itself, the pinches recorded with it may: see
    :func:`firstcontact.contact._closing_start.closings`.
    """
    start = closing_start(pinch).sample
    detector.start(pinch.layout)
    return detector.update(Block(pinch.data[start - pinch.first_sample :], start))
