"""Open and connected rows and columns of a force array whose places were pressed one by one."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

#: Least rise of a pressed taxel, V: a tenth of what 2 N give with the least conductive sheets.
RISE = 0.05
#: Largest difference between two connected lines, as a share of their rise. The pressed place
#: bears about half of the force, and each other place a tenth.
SAME = 0.25
#: Rows and columns of the fingertip's array. The number of a taxel is 2 * row + column.
ROWS, COLUMNS = 3, 2


def array_faults(rises: NDArray[np.float64]) -> list[str]:
    """Return one message for each fault, given each taxel's rise, V, shape (samples, taxels)."""
    highest = rises.max(axis=0)
    if highest.max() < RISE:
        return ["no taxel rises"]
    if highest.size != ROWS * COLUMNS:
        return [f"taxel {k} does not rise" for k in np.flatnonzero(highest < RISE)]
    dead = (highest < RISE).reshape(ROWS, COLUMNS)
    grid = rises.reshape(-1, ROWS, COLUMNS)
    messages = [f"row {r} is open" for r in range(ROWS) if dead[r].all()]
    messages += [f"column {c} is open" for c in range(COLUMNS) if dead[:, c].all()]
    messages += [
        f"taxel {COLUMNS * r + c} does not rise"
        for r, c in np.argwhere(dead)
        if not dead[r].all() and not dead[:, c].all()
    ]
    for name, lines in (("rows", np.moveaxis(grid, 1, 0)), ("columns", np.moveaxis(grid, 2, 0))):
        messages += [
            f"{name} {a} and {b} are connected"
            for a, b in combinations(range(len(lines)), 2)
            if _are_connected(lines[a], lines[b])
        ]
    return messages


def _are_connected(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    """Return True if two lines, shape (samples, taxels), always read the same, and rise."""
    rise = np.maximum(a, b).max(axis=0)
    return bool((rise > RISE).all() and (np.abs(a - b).max(axis=0) < SAME * rise).all())
