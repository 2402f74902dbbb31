"""Reduced sets of a kernel machine: fewer vectors, with refitted weights.

See B. Schölkopf et al.: Input space versus feature space in kernel-based methods, 1999, section V.
The fit minimises the error of the machine's outputs on its training windows, by orthogonal matching
pursuit: each step adds the vector that explains most of the residual.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import RbfKernel

Real = NDArray[np.float64]
#: Regularisation: share of the kernel's mean square that is added to keep weights small.
RIDGE = 1e-8


def reduced_sets(
    vectors: NDArray[Any],
    gamma: float,
    weights: NDArray[Any],
    inputs: NDArray[Any],
    sizes: Sequence[int],
) -> Iterator[tuple[NDArray[np.intp], Real, Real]]:
    """Yield reduced sets of several sizes."""
    wide = vectors.astype(np.float64)
    kernel = RbfKernel(wide, gamma).rows(inputs.astype(np.float64))
    wanted = kernel @ weights.T.astype(np.float64)
    mean = wanted.mean(axis=0)
    left = wanted - mean
    columns = kernel - kernel.mean(axis=0)
    chosen: list[int] = []
    for size in [s for s in sizes if s < len(wide)]:
        while len(chosen) < size:
            power = np.maximum((columns**2).sum(axis=0), 1e-12)
            gain = ((columns.T @ left) ** 2).sum(axis=1) / power
            gain[chosen] = -1.0
            best = int(gain.argmax())
            chosen.append(best)
            axis = columns[:, best] / np.sqrt(power[best])
            left = left - np.outer(axis, axis @ left)
            columns = columns - np.outer(axis, axis @ columns)
        part = kernel[:, chosen]
        middle = part.mean(axis=0)
        away = part - middle
        gram = away.T @ away + RIDGE * len(away) * np.eye(size)
        fitted = np.linalg.solve(gram, away.T @ (wanted - mean))
        yield np.array(chosen, np.intp), fitted.T, mean - middle @ fitted
