"""Stiffness of the pad on its six dimples under a small contact, by the place of the contact.

A contact of 2 to 3 mm does not press the whole pad: it loads the dimples near it. Finite elements
of the drawn pad (bricks with a mean dilatation, for silicone that is nearly incompressible) give
the sinking under Hertz's pressure. Without the sinking of a half space, a spring in series with
Hertz's contact is left: the twin's ``pad_stiffness``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from dimensions import NOMINAL, Dimensions
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import SuperLU, splu

from firstcontact.core.physics import POISSON
from firstcontact.twin.mechanics import FingerParameters

Values = NDArray[np.float64]
MODULUS = FingerParameters().pad_modulus
#: Corners of a brick, in units of its sides, and Gauss points between -1 and 1.
_CORNERS = np.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)])
_GAUSS = np.array([-1.0, 1.0]) / math.sqrt(3)
#: Samples along each side of a face, to weigh partly covered faces.
_FINE = 8


def _brick(sides: Values) -> Values:
    """Return the stiffness matrix of a brick with these side lengths, m, shape (24, 24)."""
    shear = MODULUS / (2 * (1 + POISSON))
    bulk = MODULUS / (3 * (1 - 2 * POISSON))
    deviatoric = shear * (np.diag([2.0, 2, 2, 1, 1, 1]) - np.pad(np.full((3, 3), 2 / 3), (0, 3)))
    signs, volume = 2.0 * _CORNERS - 1, float(np.prod(sides))
    out, mean = np.zeros((24, 24)), np.zeros(24)
    for point in np.array(np.meshgrid(_GAUSS, _GAUSS, _GAUSS)).reshape(3, -1).T:
        ends = 1 + signs * point
        slopes = (
            np.stack(
                [signs[:, a] * ends[:, (a + 1) % 3] * ends[:, (a + 2) % 3] / 4 for a in range(3)], 1
            )
            / sides
        )
        strains = np.zeros((6, 8, 3))
        for a in range(3):
            strains[a, :, a] = slopes[:, a]
            b, c = (a + 1) % 3, (a + 2) % 3
            strains[3 + a, :, b], strains[3 + a, :, c] = slopes[:, c], slopes[:, b]
        flat = strains.reshape(6, 24)
        out += volume / 8 * flat.T @ deviatoric @ flat
        mean += slopes.ravel() / 8
    return np.asarray(out + volume * bulk * np.outer(mean, mean))


@dataclass(frozen=True)
class Pad:
    """Pad on a rigid board, which holds the ends of its dimples. Lengths in m."""

    dimensions: Dimensions = NOMINAL
    cell: float = 0.5e-3
    """Largest side of an element along the pad."""
    layers: tuple[int, int] = (6, 2)
    """Number of layers of elements in pad and dimples."""
    slides: bool = False
    """True if the ends of the dimples slide on the board without friction."""

    @cached_property
    def _grid(self) -> tuple[Values, Values, Values]:
        d = self.dimensions
        length, width = 1e-3 * d.board_length, 1e-3 * d.board_width
        x, y = (
            np.linspace(-side / 2, side / 2, math.ceil(side / self.cell) + 1)
            for side in (length, width)
        )
        root = 1e-3 * d.dimple_height
        body = np.linspace(root, root + 1e-3 * d.pad_thickness, self.layers[0] + 1)
        return x, y, np.concatenate([np.linspace(0, root, self.layers[1] + 1)[:-1], body])

    def _shares(self, height: float) -> Values:
        """Return the share of each cell that is inside a dimple, shape (x cells, y cells)."""
        d = self.dimensions
        radius = d.dimple_diameter / 2 + height * 1e3 * math.tan(math.radians(d.draft))
        x, y = (_samples(line) for line in self._grid[:2])
        inside = np.zeros((x.size, y.size), bool)
        for place in d.taxels:
            a, b = (1e-3 * v for v in place)
            inside |= (x[:, None] - a) ** 2 + (y - b) ** 2 < (1e-3 * radius) ** 2
        cells = inside.reshape(x.size // _FINE, _FINE, y.size // _FINE, _FINE)
        return np.asarray(cells.mean(axis=(1, 3)))

    @cached_property
    def _solver(self) -> tuple[SuperLU, NDArray[np.int64]]:
        x, y, z = self._grid
        counts = np.array([x.size, y.size, z.size])
        number = np.arange(counts.prod()).reshape(counts)
        rows, columns, values = [], [], []
        for k in range(z.size - 1):
            sides = np.array([x[1] - x[0], y[1] - y[0], z[k + 1] - z[k]])
            share = np.ones(counts[:2] - 1)
            if k < self.layers[1]:
                share = self._shares((z[k] + z[k + 1]) / 2)
            i, j = np.nonzero(share > 0.02)
            i_corner, j_corner, k_corner = _CORNERS.T
            nodes = number[i[:, None] + i_corner, j[:, None] + j_corner, k + k_corner]
            dofs = (3 * nodes[:, :, None] + np.arange(3)).reshape(len(i), 24)
            matrix = share[i, j][:, None, None] * _brick(sides)
            rows.append(np.repeat(dofs, 24, axis=1).ravel())
            columns.append(np.tile(dofs, 24).ravel())
            values.append(matrix.ravel())
        size = 3 * int(counts.prod())
        whole = coo_matrix(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (size, size)
        ).tocsr()
        is_used = whole.diagonal() > 0
        ends = number[:, :, 0].ravel()
        is_used[3 * ends + 2] = False
        if not self.slides:
            is_used[3 * ends] = is_used[3 * ends + 1] = False
        free = np.flatnonzero(is_used)
        matrix = whole[free][:, free].tocsc()
        return splu(matrix, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}), free

    def sinking(self, place: tuple[float, float], radius: float) -> float:
        """Return how far the pad sinks under a contact, per newton of Hertz's pressure, m/N.

        It is the mean over the contact, weighted with the pressure. ``place`` and ``radius`` are
        those of the contact, m.
        """
        x, y, z = self._grid
        a, b = np.meshgrid(_samples(x), _samples(y), indexing="ij")
        squared = 1 - ((a - place[0]) ** 2 + (b - place[1]) ** 2) / radius**2
        force = np.zeros((x.size, y.size, z.size, 3))
        force[:, :, -1, 2] = _weights(x).T @ np.sqrt(np.maximum(squared, 0)) @ _weights(y)
        solver, free = self._solver
        load = force.ravel()[free] / force.sum()
        return float(load @ solver.solve(load))

    def whole(self) -> float:
        """Return the stiffness against an even pressure on the whole face, N/m."""
        return 1 / self.sinking((0.0, 0.0), 1.0)

    def spring(self, place: tuple[float, float] = (0.0, 0.0), radius: float = 2e-3) -> float:
        """Return the stiffness that remains without the sinking of a half space (Hertz), N/m.

        ``place`` and ``radius`` are those of the contact, m.
        """
        half_space = 0.6 * (1 - POISSON**2) / (MODULUS * radius)
        return 1 / (self.sinking(place, radius) - half_space)

    def springs(self, radius: float = 2e-3, steps: int = 4) -> Values:
        """Return :meth:`spring` for contacts all over the pad, N/m.

        By symmetry a quarter of the pad is enough: ``steps`` places along each side.
        """
        d = self.dimensions
        ends = 1e-3 * np.array([d.board_length, d.board_width]) / 2 - radius
        sides = [(np.arange(steps) + 0.5) / steps * end for end in ends]
        return np.array([self.spring((x, y), radius) for x in sides[0] for y in sides[1]])


def _samples(line: Values) -> Values:
    """Return the middles of the samples along a line of nodes."""
    step = (line[1] - line[0]) / _FINE
    return np.asarray(line[0] + step * (np.arange((line.size - 1) * _FINE) + 0.5))


def _weights(line: Values) -> Values:
    """Return the linear weight of each node at each sample, shape (samples, nodes)."""
    distance = np.abs(_samples(line)[:, None] - line) / (line[1] - line[0])
    return np.asarray(np.maximum(1 - distance, 0))


if __name__ == "__main__":
    for slides in (False, True):
        pad = Pad(slides=slides)
        found = pad.springs()
        print(
            f"dimples {'slide' if slides else 'stick'}: whole pad {1e-3 * pad.whole():.1f} kN/m, "
            f"a touch {1e-3 * found.min():.1f} to {1e-3 * found.max():.1f} kN/m, harmonic mean "
            f"{1e-3 / np.mean(1 / found):.1f} kN/m, scatter {np.std(np.log(found)):.2f} of ln"
        )
