"""Finite elements of the fingertip's stack, axisymmetric and with piezoelectric coupling.

Rectangles of nine nodes (biquadratic) hold the displacements in r and z. In the disc they also hold
the electric potential. One face of the disc is at ground, the other is one free electrode, so a
load gives the open-circuit voltage, and a charge gives the capacitance. Static and linear.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

Vector = NDArray[np.float64]
VACUUM = 8.854e-12
#: Unit of the potential, V. In volts the equations would mix 1e11 and 1e-8, and lose digits.
_UNIT = 1e9
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True, eq=False)
class Material:
    """Linear material with its axis along z. Isotropic, unless it is piezoelectric."""

    stiffness: Vector
    """Stiffness at constant field for the strains rr, tt, zz and rz, Pa, shape (4, 4)."""
    coupling: Vector = field(default_factory=lambda: np.zeros((2, 4)))
    """Charge per area along r and z for each strain, C/m²."""
    permittivity: Vector = field(default_factory=lambda: np.zeros(2))
    """Permittivity at constant strain along r and z, F/m."""

    @property
    def is_piezo(self) -> bool:
        """Return True if the material is piezoelectric, so that it has an electric potential."""
        return bool(self.permittivity.any())

    @property
    def matrix(self) -> Vector:
        """Matrix from strains and electric field to stresses and charge per area.

        The unit of the potential is chosen so that all entries have similar sizes.
        """
        coupling, permittivity = _UNIT * self.coupling, _UNIT**2 * np.diag(self.permittivity)
        return np.block([[self.stiffness, coupling.T], [coupling, -permittivity]])


def isotropic(modulus: float, poisson: float) -> Material:
    """Return an isotropic material from Young's modulus (Pa) and Poisson's ratio."""
    factor = modulus / ((1 + poisson) * (1 - 2 * poisson))
    stiffness = np.full((4, 4), factor * poisson)
    np.fill_diagonal(stiffness, factor * (1 - poisson))
    stiffness[3] = stiffness[:, 3] = 0.0
    stiffness[3, 3] = modulus / (2 * (1 + poisson))
    return Material(stiffness)


def piezoelectric(
    s11: float, s12: float, s13: float, s33: float, s44: float,
    d31: float, d33: float, d15: float, k11: float, k33: float,
) -> Material:  # fmt: skip
    """Return a poled ceramic from a data sheet: compliances, charge constants, free permittivity.

    Compliances are in m²/N at constant field, charge constants in C/N. Relative permittivities are
    those at constant stress.
    """
    compliance = np.array(
        [[s11, s12, s13, 0], [s12, s11, s13, 0], [s13, s13, s33, 0], [0, 0, 0, s44]]
    )
    charge = np.array([[0, 0, 0, d15], [d31, d31, d33, 0.0]])
    stiffness = np.linalg.inv(compliance)
    coupling = charge @ stiffness
    return Material(
        stiffness, coupling, VACUUM * np.array([k11, k33]) - np.diag(coupling @ charge.T)
    )


@dataclass(frozen=True)
class Layer:
    """Layer of a stack. Layers are listed from the lowest upwards."""

    thickness: float
    radius: float
    material: Material
    elements: int = 2
    """Number of elements in its thickness."""
    spot: tuple[float, Material] | None = None
    """Radius and material of a spot in its middle that differs."""


class Stack:
    """Coaxial layers on each other, on rigid ground, as finite elements. Lengths in m."""

    def __init__(
        self,
        layers: Sequence[Layer],
        size: float = 0.25e-3,
        *,
        held: tuple[float, float] = (0.0, math.inf),
        is_smooth: bool = False,
    ) -> None:
        """Build and factorise the equations.

        Parameters
        ----------
        layers
            From the ground upwards. One of them may be piezoelectric: its lower face is the free
            electrode, its upper face is at ground.
        size
            Largest length of an element along r, m.
        held
            Radii of the ring on which the lowest face rests, m. The default is all of it.
        is_smooth
            True if the ground lets the stack slide.
        """
        edges = sorted({0.0, *(q.radius for q in layers), *(q.spot[0] for q in layers if q.spot)})
        r = np.concatenate([
            [0.0], *(_graded(a, b, size)[1:] for a, b in pairwise(edges)),
        ])  # fmt: skip
        z = np.concatenate(
            [[0.0], *(np.full(q.elements, q.thickness / q.elements) for q in layers)]
        )
        z = np.cumsum(z)
        self._r = np.sort(np.concatenate([r, (r[1:] + r[:-1]) / 2]))
        self._columns = len(z) * 2 - 1
        owner = np.repeat(np.arange(len(layers)), [q.elements for q in layers])
        blocks, corner = [], [(a, b) for a in range(3) for b in range(3)]
        kinds: dict[Material, list[tuple[int, int]]] = {}
        for i in range(len(r) - 1):
            for j, k in enumerate(owner):
                layer, end = layers[k], r[i + 1] * (1 - 1e-9)
                if end <= layer.radius:
                    is_spot = layer.spot is not None and end <= layer.spot[0]
                    material = layer.spot[1] if layer.spot and is_spot else layer.material
                    kinds.setdefault(material, []).append((i, j))
        # Degrees of freedom of a node: displacements along r and z, potential.
        number = np.full((len(self._r) * self._columns, 3), -1)
        self._free, self._ground = np.array([], int), np.array([], int)
        for material, cells in kinds.items():
            i, j = np.array(cells).T
            nodes = np.stack([(2 * i + a) * self._columns + 2 * j + b for a, b in corner], axis=1)
            number[nodes, :2] = 0
            if material.is_piezo:
                number[nodes, 2] = 0
                low, high = j == j.min(), j == j.max()
                self._free = np.unique(nodes[low][:, [0, 3, 6]])
                self._ground = np.unique(nodes[high][:, [2, 5, 8]])
            blocks.append((nodes, _matrices(material, r[i], r[i + 1], z[j], z[j + 1])))
        rests = (self._r >= held[0]) & (self._r <= held[1])
        ground = np.flatnonzero(rests) * self._columns
        number[ground, 1] = -1
        if not is_smooth:
            number[ground, 0] = -1
        number[np.arange(self._columns), 0] = -1  # the axis
        number[self._ground, 2] = -1
        number[self._free[1:], 2] = -1
        self._count = int((number >= 0).sum())
        number[number >= 0] = np.arange(self._count)
        number[self._free, 2] = number[self._free[:1], 2]
        self._number = number
        rows, columns, values = [], [], []
        for nodes, matrices in blocks:
            dof = number[nodes].reshape(len(nodes), 27)
            pair = np.broadcast_arrays(dof[:, :, None], dof[:, None, :])
            keep = (pair[0] >= 0) & (pair[1] >= 0)
            rows.append(pair[0][keep])
            columns.append(pair[1][keep])
            values.append(matrices[keep])
        index = np.concatenate(rows), np.concatenate(columns)
        shape = (self._count, self._count)
        self._solve = splu(coo_array((np.concatenate(values), index), shape).tocsc()).solve

    @property
    def _electrode(self) -> int:
        return int(self._number[self._free[0], 2])

    def pressed(self, inner: float, outer: float, *, is_below: bool = False) -> Vector:
        """Return the solution for 1 N downwards, spread evenly over a ring of the top face.

        ``inner`` and ``outer`` are the ring's radii, m. ``is_below`` puts the load on the lowest
        face.
        """
        load = np.zeros(self._count)
        top = np.arange(len(self._r)) * self._columns + (0 if is_below else self._columns - 1)
        area = math.pi * (outer**2 - inner**2)
        for i in range(0, len(self._r) - 2, 2):
            a, b = max(self._r[i], inner), min(self._r[i + 2], outer)
            if a >= b:
                continue
            radii = (a + b) / 2 + (b - a) / 2 * _POINTS
            place = (2 * radii - self._r[i] - self._r[i + 2]) / (self._r[i + 2] - self._r[i])
            force = _WEIGHTS * (b - a) / 2 * 2 * math.pi * radii / area
            load[self._number[top[i : i + 3], 1]] -= _shapes(place)[0].T @ force
        return np.asarray(self._solve(load))

    def volts_per_newton(self, inner: float, outer: float, *, is_below: bool = False) -> float:
        """Return the open-circuit voltage of the free electrode per newton on a ring, V/N.

        ``inner`` and ``outer`` are the ring's radii, m. ``is_below`` puts the load on the lowest
        face.
        """
        return _UNIT * float(self.pressed(inner, outer, is_below=is_below)[self._electrode])

    def sinking(self, inner: float, outer: float) -> tuple[float, float]:
        """Return how far middle and rim of the top face sink per newton on a ring, m/N.

        ``inner`` and ``outer`` are the ring's radii, m.
        """
        solution = self.pressed(inner, outer)
        middle, rim = self._number[self._columns - 1 :: self._columns, 1][[0, -1]]
        return -float(solution[middle]), -float(solution[rim])

    def capacitance(self) -> float:
        """Return the capacitance of the disc in the stack, F."""
        charge = np.zeros(self._count)
        charge[self._electrode] = -1.0
        return 1 / float(_UNIT**2 * self._solve(charge)[self._electrode])


def _graded(a: float, b: float, size: float) -> Vector:
    """Return node positions from ``a`` to ``b``, closer near both ends, where layers end."""
    count = max(4, math.ceil((b - a) / size))
    return (a + b) / 2 - (b - a) / 2 * np.cos(np.linspace(0, math.pi, count + 1))


def _shapes(x: Vector) -> tuple[Vector, Vector]:
    """Return values and slopes of the three quadratic shape functions, (points, 3) each.

    ``x`` lies in (-1, 1).
    """
    shapes = np.stack([x * (x - 1) / 2, 1 - x**2, x * (x + 1) / 2], axis=-1)
    return shapes, np.stack([x - 0.5, -2 * x, x + 0.5], axis=-1)


def _matrices(material: Material, r0: Vector, r1: Vector, z0: Vector, z1: Vector) -> Vector:
    """Return the matrices of elements of one material, shape (elements, 27, 27).

    The elements extend from ``r0`` to ``r1`` and from ``z0`` to ``z1``, m.
    """
    shapes, slopes = _shapes(_POINTS)
    total = np.zeros((len(r0), 27, 27))
    for p, x in enumerate(_POINTS):
        radius = (r0 + r1) / 2 + (r1 - r0) / 2 * x
        for q in range(3):
            n = np.outer(shapes[p], shapes[q]).ravel()
            along_r = np.outer(slopes[p], shapes[q]).ravel() * (2 / (r1 - r0))[:, None]
            along_z = np.outer(shapes[p], slopes[q]).ravel() * (2 / (z1 - z0))[:, None]
            b = np.zeros((len(r0), 6, 9, 3))
            b[:, 0, :, 0] = along_r
            b[:, 1, :, 0] = n / radius[:, None]
            b[:, 2, :, 1] = along_z
            b[:, 3, :, 0], b[:, 3, :, 1] = along_z, along_r
            b[:, 4, :, 2], b[:, 5, :, 2] = along_r, along_z
            b = b.reshape(len(r0), 6, 27)
            volume = _WEIGHTS[p] * _WEIGHTS[q] * (r1 - r0) * (z1 - z0) / 4 * 2 * math.pi * radius
            total += np.swapaxes(b, 1, 2) @ material.matrix @ b * volume[:, None, None]
    return total
