"""Radial basis function (RBF) kernel in NumPy, used by all kernel machines."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[Any]  # of float32 or float64


class RbfKernel:
    """RBF kernel ``exp(-gamma |x - v|²)`` between inputs x and fixed vectors v.

    ``vectors`` are the support vectors v of a kernel machine, shape (vectors, features).
    """

    def __init__(self, vectors: Real, gamma: float) -> None:
        self._gamma = gamma
        with np.errstate(all="ignore"):
            # Column order makes the product with one input twice as fast.
            self._scaled = np.asfortranarray(2.0 * gamma * vectors)
            norms = -gamma * np.einsum("ij,ij->i", vectors, vectors)
        # Overflow gives NaN, so that no decision follows from it.
        self._norms = np.where(np.isfinite(norms), norms, np.nan).astype(vectors.dtype)

    def __len__(self) -> int:
        return len(self._norms)

    def rows(self, x: Real) -> Real:
        """Return the kernel values, shape (n, vectors), of n inputs, shape (n, features)."""
        exponent = x @ self._scaled.T
        exponent += self._norms
        exponent -= self._gamma * np.einsum("ij,ij->i", x, x)[:, None]
        return np.exp(exponent, out=exponent)
