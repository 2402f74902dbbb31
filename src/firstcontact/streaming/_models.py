"""A model of fixed windows as the live pipeline asks it: with its interval."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError

if TYPE_CHECKING:
    from firstcontact.models import Interval, WindowModel


@dataclass(frozen=True, slots=True)
class ModelWithInterval:
    """A model and the interval around its answers, None where it has none."""

    model: WindowModel
    interval: Interval | None = None

    @classmethod
    def load(cls, folder: Path) -> ModelWithInterval:
        """As a model's folder holds them; InputError if it is damaged or there is none."""
        from firstcontact.models import load_interval, load_window_model

        return cls(load_window_model(folder), load_interval(folder))

    def bounds(self, value: float, window: NDArray[np.float32]) -> tuple[float, float, float]:
        """Lower and upper bound of an answer about a window, and the level of the interval."""
        interval = self.interval
        if interval is None:
            return value, value, 0.0
        if not interval.scaled:
            return *interval.around(value), interval.level
        spread = self.model.spread(window[None])
        if spread is None:
            raise InputError("the model's interval is scaled by a spread that it has not")
        return *interval.around(value, float(spread[0])), interval.level
