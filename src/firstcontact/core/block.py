"""Consecutive samples as they travel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Consecutive samples of one epoch.

    Parameters
    ----------
    data
        Raw samples, shape (samples, channels).
    first_sample
        Device sample number of ``data[0]``.
    epoch
        Counts device starts; samples of two epochs are never joined.
    """

    data: NDArray[Any]
    first_sample: int = 0
    epoch: int = 0

    @property
    def end(self) -> int:
        """Sample number that the next block of an unbroken stream starts with."""
        return self.first_sample + len(self.data)
