"""Gaussian process on the features of a rig's own pinches, at each stage after the contact."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError, take_array
from firstcontact.models._contact_features import NAMES
from firstcontact.models._interval import SHORE_A
from firstcontact.models._rig import STAGES
from firstcontact.models._spec import Arrays, Values

#: Positions of the regression's inputs in those of the network: the features and the closing speed.
INPUTS = slice(3 * STAGES[-1], 3 * STAGES[-1] + len(NAMES) + 1)
WIDTH = INPUTS.stop - INPUTS.start
#: Length scale in standard deviations of an input, and variances of the linear part and of the
#: noise. The smooth part and the constant have variance 1. All rigs have the same values. Values
#: that were chosen on held-out pinches of each rig scored no better on rigs whose structure differs
#: from that of the network's training rigs.
LENGTH, LINEAR, NOISE = 2.0, 1.0, 0.3
#: Added to the standard deviation of each input.
_LEAST_SPREAD = 0.1
#: Largest number of pinches, and limit to which inputs (about 1 in size) are clipped. A contact
#: without a first swing has inputs a thousand times as large.
MOST, LARGEST = 160, 10.0


class RigRegression:
    """Regression from features to Shore A, fitted to the pinches of one rig alone.

    Parameters
    ----------
    inputs
        Features of the pinches, shape (stages, n, ``WIDTH``).
    shore_a
        Shore A of the objects, shape (n,).
    scale
        Factor on the spread at each stage, shape (stages,).

    Raises
    ------
    InputError
        Values of the arrays are out of range.
    """

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
        mean, sd = inputs.mean(axis=1), inputs.std(axis=1) + _LEAST_SPREAD
        self._centre, self._unit = float(shore_a.mean()), max(float(shore_a.std()), 1.0)
        targets = (shore_a - self._centre) / self._unit
        self._stages = [
            _Stage.fit((x - m) / s, targets, m, s) for x, m, s in zip(inputs, mean, sd, strict=True)
        ]

    def predict(self, inputs: NDArray[np.float64], stage: int) -> tuple[float, float]:
        """Return Shore A and its spread for the features of one contact, shape (``WIDTH``,)."""
        mean, sd, known_inputs, squares, weights, inverse = self._stages[stage]
        x = (inputs.clip(-LARGEST, LARGEST) - mean) / sd
        square = float(x @ x)
        kernel = _kernel(known_inputs @ x, squares + square)
        value = self._centre + self._unit * float(kernel @ weights)
        prior = 2.0 + LINEAR * square / WIDTH
        unexplained = max(prior - float(kernel @ (inverse @ kernel)), 0.0)
        spread = self._unit * math.sqrt(unexplained + NOISE) * float(self._scale[stage])
        least, most = SHORE_A
        return min(max(value, least), most), spread

    @property
    def constants(self) -> tuple[float, float, int]:
        """Mean and scale of the targets, and the number of pinches."""
        return self._centre, self._unit, len(self._shore_a)

    def stacked(self) -> tuple[NDArray[np.float64], ...]:
        """Return the arrays that :meth:`predict` uses. The first axis of each is the stage.

        The known inputs have the shape (stages, ``WIDTH``, n). The last array is the scale.
        """
        mean, sd, known_inputs, *fitted = map(np.stack, zip(*self._stages, strict=True))
        return mean, sd, known_inputs.transpose(0, 2, 1), *fitted, self._scale

    def to_arrays(self) -> Arrays:
        """Return the regression as arrays, for :meth:`from_arrays`."""
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


class _Stage(NamedTuple):
    """Gaussian process at one stage. ``squares`` are squared lengths of ``known_inputs``."""

    mean: NDArray[np.float64]
    sd: NDArray[np.float64]
    known_inputs: NDArray[np.float64]
    squares: NDArray[np.float64]
    weights: NDArray[np.float64]
    inverse: NDArray[np.float64]

    @classmethod
    def fit(
        cls,
        known_inputs: NDArray[np.float64],
        targets: Values,
        mean: NDArray[np.float64],
        sd: NDArray[np.float64],
    ) -> Self:
        squares = np.einsum("ij,ij->i", known_inputs, known_inputs)
        covariance = _kernel(known_inputs @ known_inputs.T, squares[:, None] + squares)
        inverse = np.linalg.inv(covariance + NOISE * np.eye(len(known_inputs))).astype(np.float64)
        return cls(mean, sd, known_inputs, squares, inverse @ targets, inverse)


def _kernel(inner: NDArray[np.float64], squares: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the covariance of standardised inputs: a constant plus a linear and a smooth part.

    Parameters
    ----------
    inner
        Inner products of pairs of inputs.
    squares
        Sum of the squared lengths of both inputs of each pair.
    """
    distances = np.maximum(squares - 2.0 * inner, 0.0)
    smooth = np.exp(distances * (-1.0 / (2.0 * LENGTH * LENGTH * WIDTH)))
    out: NDArray[np.float64] = 1.0 + inner * (LINEAR / WIDTH) + smooth
    return out
