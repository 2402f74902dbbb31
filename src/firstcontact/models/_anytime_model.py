"""Models that predict at any time after a contact, and their predictions."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from firstcontact.models._spec import Values
from firstcontact.models._touches import Touches

Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Answers:
    """Predicted stiffness with interval, one per contact.

    Parameters
    ----------
    values
        Shore A, shape (n,).
    spreads
        Standard deviation that the model gives each, Shore A, shape (n,).
    low, high
        Ends of the interval, Shore A, shape (n,).
    strange
        Whether the contact is like nothing that was learned from: the interval may not hold.
        Shape (n,).
    """

    values: Values
    spreads: Values
    low: Values
    high: Values
    strange: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.values)


class Answering(Protocol):
    """Predictor of stiffness from the valid part of contacts."""

    def answers(self, touches: Touches) -> Answers:
        """Return predictions from the valid part of each contact."""
        ...


class AnytimeModel(ABC):
    """Answers from 2 ms after a contact on, at any sample, each time with an interval."""

    #: Name of the runtime in model files.
    kind: ClassVar[str]
    #: Sampling rate that it takes, Hz, and share of its intervals that are to hold the truth.
    rate: float
    level: float

    @abstractmethod
    def answers(self, touches: Touches) -> Answers:
        """Return predictions from the valid part of each contact.

        Raises
        ------
        InputError
            Contacts at another rate, or with fewer valid samples than an answer takes.
        """

    @abstractmethod
    def to_arrays(self) -> Arrays:
        """Return all arrays that predictions depend on."""
