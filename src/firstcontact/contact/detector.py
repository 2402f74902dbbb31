"""Interface of contact detectors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain.image import DetectorConstants
from firstcontact.core import Dataset


@dataclass(frozen=True, slots=True, eq=False)
class WindowDecisions:
    """Decisions of a detector for single windows."""

    #: Number of the last sample of each window, shape (windows,).
    ends: NDArray[np.int64]
    #: Mask of the windows with a contact in their newest part, shape (windows, channels).
    fired: NDArray[np.bool_]
    #: Number of the sample at which that contact began, -1 without one, same shape.
    onsets: NDArray[np.int64]


class Detector(Protocol):
    """Contact detector: constants for the chain, or a Python function of windows.

    Most detectors extend :class:`firstcontact.contact._window_detector.WindowDetector`, which
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

        ``early`` is the longest time by which a contact may come before its label, s. Raise
        InputError if the pinches do not suffice for training.
        """

    def constants(self, rate: float) -> DetectorConstants:
        """Return the constants for the chain at a rate in Hz, or raise InputError."""

    def settled(self, quiet: NDArray[np.float64]) -> None:
        """Learn from a steady state in its sigmas, shape (samples, fingers)."""

    def fires(self, windows: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return a mask of windows with a contact, for constants of the kind PROGRAM.

        ``windows`` has the shape (windows, fingers, samples), the mask (windows, fingers).
        """

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        """Return all learned numbers and options for saving. Raise InputError if not trained."""

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Restore a detector from :meth:`to_arrays`. Raise InputError if the arrays are invalid."""
