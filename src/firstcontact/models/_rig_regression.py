"""Gaussian process on the features of a rig's own pinches, at each stage after the contact."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError, take_array
from firstcontact.models._contact_features import NAMES
from firstcontact.models._interval import SHORE_A
from firstcontact.models._rig import STAGES
from firstcontact.models._spec import Arrays, Values

#: Inputs among those of the network: the features and the closing speed that the motor sounds like.
INPUTS = slice(3 * STAGES[-1], 3 * STAGES[-1] + len(NAMES) + 1)
WIDTH = INPUTS.stop - INPUTS.start
#: Length scale in standard deviations of an input, and variances of the linear part and of the
#: noise; the smooth part and the constant have 1. They hold for every rig: a search on its held-out
#: pinches scored no better on rigs of other structure.
LENGTH, LINEAR, NOISE = 2.0, 1.0, 0.3
#: Added to the standard deviation of each input.
_LEAST_SPREAD = 0.1
#: Most pinches. Inputs are about 1 in size and are clipped here: a contact without a first swing
#: has some that are a thousand times as large.
MOST, LARGEST = 160, 10.0


class RigRegression:
    """Regression of Shore A on features, fitted to the pinches of one rig alone.

    Parameters
    ----------
    inputs
        Features of the pinches, shape (stages, n, ``WIDTH``).
    shore_a
        Shore A of the objects, shape (n,).
    scale
        Factor of its spread at each stage, shape (stages,).

    Raises
    ------
    InputError
        Arrays are out of range.
    """

    def __init__(
        self, inputs: NDArray[np.float64], shore_a: Values, scale: NDArray[np.float64]
    ) -> None:
        n = len(shore_a)
        if not 2 <= n <= MOST or not (scale > 0).all():
            raise InputError("the pinches of the rig's regression are out of range")
        inputs = np.clip(inputs, -LARGEST, LARGEST)
        self._inputs, self._shore_a, self._scale = inputs, shore_a, scale
        self._mean, self._sd = inputs.mean(axis=1), inputs.std(axis=1) + _LEAST_SPREAD
        self._centre, self._unit = shore_a.mean(), max(float(shore_a.std()), 1.0)
        self._known = (inputs - self._mean[:, None]) / self._sd[:, None]
        self._inverse = np.stack(
            [np.linalg.inv(_kernel(x, x) + NOISE * np.eye(n)) for x in self._known]
        )
        self._weights = self._inverse @ ((shore_a - self._centre) / self._unit)

    def scaled(self, scale: NDArray[np.float64]) -> RigRegression:
        """Return the regression with its spread at each stage multiplied by these factors."""
        return RigRegression(self._inputs, self._shore_a, scale)

    def predict(self, inputs: NDArray[np.float64], stage: int) -> tuple[Values, Values]:
        """Return Shore A and its spread, shape (n,) each, for features at one stage."""
        x = (np.clip(inputs, -LARGEST, LARGEST) - self._mean[stage]) / self._sd[stage]
        kernel = _kernel(x, self._known[stage])
        values = self._centre + self._unit * (kernel @ self._weights[stage])
        prior = 2.0 + LINEAR * np.einsum("ij,ij->i", x, x) / WIDTH
        explained = np.einsum("ij,ij->i", kernel @ self._inverse[stage], kernel)
        spreads = self._unit * np.sqrt(np.maximum(prior - explained, 0.0) + NOISE)
        return np.clip(values, *SHORE_A), spreads * self._scale[stage]

    def to_arrays(self) -> Arrays:
        """Return the inverse of :meth:`from_arrays`."""
        return {"inputs": self._inputs, "shore_a": self._shore_a, "scale": self._scale}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]], at: str) -> Self:
        """Return the regression in the arrays whose names begin with ``at``.

        Raises
        ------
        InputError
            Arrays are missing or do not fit together.
        """
        shore_a = take_array(arrays, at + "shore_a", None).astype(np.float64)
        inputs = take_array(arrays, at + "inputs", len(STAGES), len(shore_a), WIDTH)
        scale = take_array(arrays, at + "scale", len(STAGES)).astype(np.float64)
        return cls(inputs.astype(np.float64), shore_a, scale)


def _kernel(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the covariance of two sets of standardised inputs: constant, linear and smooth."""
    inner = a @ b.T
    squares = np.einsum("ij,ij->i", a, a)[:, None] + np.einsum("ij,ij->i", b, b) - 2.0 * inner
    smooth = np.exp(-np.maximum(squares, 0.0) / (2.0 * LENGTH * LENGTH * WIDTH))
    out: NDArray[np.float64] = 1.0 + LINEAR * inner / WIDTH + smooth
    return out
