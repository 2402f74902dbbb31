"""Gaussian process on the features of a rig's own pinches, at each stage after the contact."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain import HINTS, INPUTS, ProcessConstants
from firstcontact.core import InputError, take_array
from firstcontact.models._rig import FEATURES, STAGES
from firstcontact.models._spec import Arrays, Values

#: Positions of the regression's inputs in those of the network: the features and the closing speed.
REGRESSED = slice(INPUTS - HINTS - FEATURES, INPUTS - HINTS + 1)
WIDTH = FEATURES + 1
#: Length scale in standard deviations of an input, and variances of the linear part and of the
#: noise. The smooth part and the constant have variance 1. All rigs have the same values. Values
#: that were chosen on held-out pinches of each rig scored no better on rigs whose structure differs
#: from that of the network's training rigs.
LENGTH, LINEAR, NOISE = 2.0, 1.0, 0.3
#: Added to the standard deviation of each input.
_LEAST_SPREAD = 0.1
#: Largest number of pinches. With more, the regression is surer of itself but not better on objects
#: unlike the rig's blocks.
MOST = 32
#: Limit to which inputs (about 1 in size) are clipped. A contact without a first swing has inputs a
#: thousand times as large.
LARGEST = 10.0


class RigRegression:
    """Regression from features to Shore A, fitted to the pinches of one rig alone."""

    def __init__(
        self, inputs: NDArray[np.float64], shore_a: Values, scale: NDArray[np.float64]
    ) -> None:
        n = len(shore_a)
        if not 2 <= n <= MOST or not (scale > 0).all():
            raise InputError(
                f"the regression of a rig needs 2 to {MOST} pinches, and scales above 0: adapt "
                "the model again"
            )
        inputs = np.clip(inputs, -LARGEST, LARGEST)
        self._inputs, self._shore_a, self._scale = inputs, shore_a, scale

    def constants(self) -> ProcessConstants:
        """Return what the chain needs to predict."""
        inputs, shore_a = self._inputs, self._shore_a
        mean, sd = inputs.mean(axis=1), inputs.std(axis=1) + _LEAST_SPREAD
        centre, unit = float(shore_a.mean()), max(float(shore_a.std()), 1.0)
        known = (inputs - mean[:, None]) / sd[:, None]
        inner = known @ known.transpose(0, 2, 1)
        squares = np.einsum("sii->si", inner)
        distances = np.maximum(squares[:, :, None] + squares[:, None] - 2.0 * inner, 0.0)
        smooth = np.exp(distances * (-1.0 / (2.0 * LENGTH * LENGTH * WIDTH)))
        covariance = 1.0 + inner * (LINEAR / WIDTH) + smooth + NOISE * np.eye(len(shore_a))
        factor = np.linalg.inv(np.linalg.cholesky(covariance))
        weights = factor.transpose(0, 2, 1) @ (factor @ ((shore_a - centre) / unit)[:, None])
        return ProcessConstants(
            centre=centre,
            unit=unit,
            mean=mean,
            sd=sd,
            known=known.transpose(0, 2, 1),
            weights=weights[..., 0],
            factor=factor,
            scale=self._scale,
        )

    def to_arrays(self) -> Arrays:
        """Return the regression as arrays, for :meth:`from_arrays`."""
        return {"inputs": self._inputs, "shore_a": self._shore_a, "scale": self._scale}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]], at: str) -> Self:
        """Return the regression in the arrays whose names begin with ``at``."""
        shore_a = take_array(arrays, at + "shore_a", None).astype(np.float64)
        inputs = take_array(arrays, at + "inputs", len(STAGES), len(shore_a), WIDTH)
        scale = take_array(arrays, at + "scale", len(STAGES)).astype(np.float64)
        return cls(inputs.astype(np.float64), shore_a, scale)
