"""The radial basis function kernel of every kernel machine here, at work: NumPy, no library."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[Any]  # of float32 or float64


class RbfKernel:
    """Kernel ``exp(-gamma |x - v|²)`` of inputs with fixed vectors, in the vectors' precision.

    Taken apart into ``exp(2 gamma v·x - gamma |v|² - gamma |x|²)``, so that one
    input costs one matrix-vector product and one exponential for each vector.

    Parameters
    ----------
    vectors
        float32 or float64, shape (vectors, inputs).
    gamma
        Above 0.
    """

    def __init__(self, vectors: Real, gamma: float) -> None:
        self._gamma = gamma
        with np.errstate(all="ignore"):
            # Column by column: the product with one input is then twice as fast.
            self._steep = np.asfortranarray(2.0 * gamma * vectors)
            norms = -gamma * np.einsum("ij,ij->i", vectors, vectors)
        # What overflows is neither near nor far: no decision may come of it.
        self._norms = np.where(np.isfinite(norms), norms, np.nan).astype(vectors.dtype)

    def __len__(self) -> int:
        return len(self._norms)

    def rows(self, x: Real) -> Real:
        """With inputs (n, inputs), shape (n, vectors)."""
        exponent = x @ self._steep.T
        exponent += self._norms
        exponent -= self._gamma * np.einsum("ij,ij->i", x, x)[:, None]
        return np.exp(exponent, out=exponent)

    def row(self, x: Real, square: float) -> Real:
        """With one input (inputs,) whose squares sum up to ``square``: shape (vectors,)."""
        exponent: Real = self._steep.dot(x)
        exponent += self._norms
        exponent -= self._gamma * square
        return np.exp(exponent, out=exponent)
