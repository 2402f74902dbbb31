"""Interface of contact detectors, and the latch that reports each finger once in a closing.

A finger is latched after its first contact. It is not reported again until the next closing, or
until the contact is withdrawn.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, Contact, Dataset, Finger, Layout


@dataclass(frozen=True, slots=True, eq=False)
class WindowDecisions:
    """Decisions of a detector for single windows, before latching.

    Parameters
    ----------
    ends
        Number of the last sample of each window, shape (windows,).
    fired
        Mask of the windows with a contact in their newest part, shape (windows, vibration
        channels).
    onsets
        Number of the sample at which that contact began, -1 without a contact; same shape as
        ``fired``.
    """

    ends: NDArray[np.int64]
    fired: NDArray[np.bool_]
    onsets: NDArray[np.int64]


def latch(
    decisions: WindowDecisions, fingers: Sequence[Finger | None], latched: set[Finger | None]
) -> list[Contact]:
    """Return the first detection of each finger that is not latched yet, and latch it.

    Parameters
    ----------
    decisions
        Decisions in time order.
    fingers
        Finger of each column; None for a sensor that belongs to no finger.
    latched
        Fingers with a contact already. Newly detected fingers are added.

    Returns
    -------
    list of Contact
        Contacts in window order; within one window, the earlier onset first.
    """
    contacts: list[Contact] = []
    for end, onsets in fired_windows(decisions):
        contacts += latch_window(end, onsets, fingers, latched)
    return contacts


def fired_windows(decisions: WindowDecisions) -> Iterator[tuple[int, list[int | None]]]:
    """Yield the last sample of each window that fired, and the onset in each column.

    The onset is None in a column without a contact.
    """
    if not decisions.fired.any():
        return
    rows = np.flatnonzero(decisions.fired.any(axis=1))
    columns = (
        array[rows].tolist() for array in (decisions.ends, decisions.fired, decisions.onsets)
    )
    for end, fired, onsets in zip(*columns, strict=True):
        yield end, [onset if f else None for f, onset in zip(fired, onsets, strict=True)]


def latch_window(
    end: int,
    onsets: Sequence[int | None],
    fingers: Sequence[Finger | None],
    latched: set[Finger | None],
) -> list[Contact]:
    """Return the new contacts of one result of :func:`fired_windows`, and latch their fingers."""
    contacts = [
        Contact(finger, onset, end)
        for finger, onset in zip(fingers, onsets, strict=True)
        if onset is not None and finger not in latched
    ]
    latched.update(contact.finger for contact in contacts)
    return sorted(contacts, key=lambda contact: contact.sample)


class Detector(Protocol):
    """Contact detector for a stream of blocks.

    The contacts do not depend on how the stream is split into blocks, so offline and live results
    agree. Most detectors extend :class:`firstcontact.contact._stream.WindowDetector`, which
    provides everything except the decision itself.
    """

    #: Name on the command line, in files and in results.
    name: ClassVar[str]
    #: Title for people, and colour in figures.
    title: ClassVar[str]
    colour: ClassVar[str]
    #: True if :meth:`fit` learns from data.
    learns: ClassVar[bool]
    #: Length of a window and of its new part, s. There is one decision per new part.
    duration: ClassVar[float]
    step: ClassVar[float]

    @property
    def rate(self) -> float | None:
        """Required sampling rate, Hz; None accepts any."""

    def fit(self, dataset: Dataset, early: float = 0.0) -> Self:
        """Learn from pinches with known contacts.

        Parameters
        ----------
        dataset
            Pinches.
        early
            Longest time by which a contact may come before its label, s.

        Raises
        ------
        InputError
            The pinches do not suffice for training.
        """

    def start(self, layout: Layout) -> None:
        """Start a new closing: forget all earlier samples and contacts."""

    def judge(self, block: Block) -> WindowDecisions:
        """Return the decisions for the windows that this block completes.

        After a gap, the detector measures the noise of the motor (its steady state) again. No
        window spans a gap, two epochs or a sample that is not finite.
        """

    def update(self, block: Block) -> list[Contact]:
        """Return the contacts that this block reveals, at most one per finger and closing."""

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        """Return all learned numbers and options for saving. Raise InputError if not trained."""

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Restore a detector from :meth:`to_arrays`. Raise InputError if the arrays are invalid."""
