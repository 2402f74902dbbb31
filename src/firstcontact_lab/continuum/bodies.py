"""Axisymmetric bodies of finite elements: meshes, masses and stiffness matrices.

Elements are quadrilaterals with four nodes and a mean dilatation (B-bar), so that nearly
incompressible material does not lock. Strains are small. Coordinates are radius r and height z. A
body lies above the fingertip, which touches it at r = 0, z = 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix

from firstcontact.core.physics import POISSON

Values = NDArray[np.float64]
Indices = NDArray[np.int64]
#: Corners of an element in its own coordinates, and its Gauss points.
_CORNERS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
_POINTS = _CORNERS / math.sqrt(3)
#: Size of elements at the contact, m, growth from one to the next outside it, and its radius, m.
SIZE, GROWTH, NEAR = 0.25e-3, 1.15, 3e-3


@dataclass(frozen=True)
class Material:
    """Nearly incompressible material whose resistance to shear relaxes over time."""

    density: float
    """Density, kg/m³."""
    modulus: float
    """Young's modulus after all relaxation, Pa."""
    arms: tuple[tuple[float, float], ...] = ()
    """Maxwell arms on shear: share of the slow shear modulus, and relaxation time, s."""

    @property
    def wave_modulus(self) -> float:
        """Ratio of stress to strain along one axis while the other two axes cannot move, Pa."""
        return self.modulus * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))


@dataclass(frozen=True)
class Body:
    """Mesh of one body of a single material. Lengths are in m."""

    nodes: Values
    """Radius and height of each node, shape (n, 2)."""
    quads: Indices
    """Nodes of each element, counterclockwise, shape (m, 4)."""
    surface: Indices
    """Nodes of the face that can touch, from the axis outwards."""
    material: Material

    @cached_property
    def masses(self) -> Values:
        """Mass of each node, kg."""
        shape = (1 + _CORNERS[:, 0] * _POINTS[:, None, 0]) * (
            1 + _CORNERS[:, 1] * _POINTS[:, None, 1]
        )
        volume = self._slopes[1]
        each = self.material.density * np.einsum("mp,pn->mn", volume, shape / 4)
        return np.asarray(np.bincount(self.quads.ravel(), each.ravel()), float)

    @cached_property
    def _slopes(self) -> tuple[Values, Values]:
        """Return the strains of each element per node displacement, and the volumes of elements.

        The strains are radial, axial, hoop and shear, shape (elements, 4 integration points, 4
        strains, 8 displacements). The volumes, m³, are those of the integration points, shape
        (elements, 4).
        """
        corners = self.nodes[self.quads]
        x, y = _POINTS.T[:, :, None]
        a, b = _CORNERS.T
        local = np.stack([a * (1 + b * y), b * (1 + a * x)], 1) / 4  # (points, 2, nodes)
        shape = (1 + a * x) * (1 + b * y) / 4
        jacobian = np.einsum("pin,mnj->mpij", local, corners)
        slopes = np.linalg.solve(jacobian, local[None])
        radius = np.einsum("pn,mn->mp", shape, corners[:, :, 0])
        strains = np.zeros((*radius.shape, 4, 4, 2))  # r, z, hoop, shear; then node, direction
        strains[..., 0, :, 0] = strains[..., 3, :, 1] = slopes[:, :, 0]
        strains[..., 1, :, 1] = strains[..., 3, :, 0] = slopes[:, :, 1]
        strains[..., 2, :, 0] = shape / radius[..., None]
        volume = 2 * math.pi * radius * np.linalg.det(jacobian)
        return strains.reshape(*radius.shape, 4, 8), volume

    @cached_property
    def stiffness(self) -> tuple[csr_matrix, csr_matrix]:
        """Stiffness matrices, N/m: (for changes of volume, for shear after relaxation).

        Rows and columns are the displacements r and z of node 0, then those of node 1, and so on.
        """
        shear = self.material.modulus / (2 * (1 + POISSON))
        bulk = self.material.modulus / (3 * (1 - 2 * POISSON))
        strains, volume = self._slopes
        elastic = np.diag([2.0, 2.0, 2.0, 1.0])
        elastic[:3, :3] -= 2 / 3
        sheared = np.einsum(
            "mp,mpia,ij,mpjb->mab", shear * volume, strains, elastic, strains, optimize=True
        )
        total = volume.sum(axis=1)
        swelling = np.einsum("mp,mpia->ma", volume, strains[:, :, :3]) / total[:, None]
        swollen = (bulk * total)[:, None, None] * swelling[:, :, None] * swelling[:, None, :]
        return self._assembled(swollen), self._assembled(sheared)

    def _assembled(self, matrices: Values) -> csr_matrix:
        unknowns = (2 * self.quads[:, :, None] + np.arange(2)).reshape(-1, 8)
        rows, columns = np.repeat(unknowns, 8, axis=1), np.tile(unknowns, 8)
        size = 2 * len(self.nodes)
        whole = coo_matrix(
            (matrices.ravel(), (rows.ravel(), columns.ravel())), (size, size)
        ).tocsr()
        # Nodes on the axis have no radial motion.
        moves = np.ones(size)
        moves[2 * np.flatnonzero(self.nodes[:, 0] < 1e-9)] = 0.0
        return whole.multiply(moves[:, None]).multiply(moves).tocsr()

    @cached_property
    def areas(self) -> Values:
        """Area of the touched face, m², divided among the nodes of this face."""
        return _ring_areas(self.nodes[self.surface, 0])

    @property
    def size(self) -> float:
        """Element size: the distance between the first two nodes of the touched face, m."""
        return float(self.nodes[self.surface[1], 0])

    def back(self) -> tuple[Indices, Values]:
        """(displacement indices, area shares) of the nodes on the face opposite to the touched one.

        An index is that of a node's displacement in height, in a vector of all displacements. The
        shares add up to 1.
        """
        nodes = np.flatnonzero(self.nodes[:, 1] > self.nodes[:, 1].max() - 1e-9)
        areas = _ring_areas(self.nodes[nodes, 0])
        return 2 * nodes + 1, areas / areas.sum()


def _ring_areas(radii: Values) -> Values:
    """Return the share of each node in the area of a flat round face, m². ``radii`` are in m."""
    inner, outer = radii[:-1], radii[1:]
    width = math.pi * (outer - inner) / 3
    areas = np.zeros(radii.size)
    areas[:-1] += width * (2 * inner + outer)
    areas[1:] += width * (inner + 2 * outer)
    return areas


def graded_positions(length: float, size: float = SIZE, near: float = NEAR) -> Values:
    """Return node positions, m, from 0 to ``length``.

    They are ``size`` m apart up to ``near`` m, and then increasingly farther apart.
    """
    steps = [size] * round(min(near, length) / size)
    while sum(steps) < length:
        steps.append(steps[-1] * GROWTH)
    line = np.concatenate([[0.0], np.cumsum(steps)])
    return np.asarray(line * length / line[-1])


def _grid(r: Values, z: Values, material: Material) -> Body:
    """Return a body whose nodes form a grid of the radii ``r`` and the heights ``z``, m.

    The finger touches row 0.
    """
    number = np.arange(r.size).reshape(r.shape)
    quads = np.stack(
        [number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1
    ).reshape(-1, 4)
    surface = np.arange(np.argmax(r[0] > 2 * NEAR))
    return Body(np.stack([r.ravel(), z.ravel()], 1), quads, surface, material)


def cylinder(radius: float, length: float, material: Material, size: float = SIZE) -> Body:
    """Return the mesh of a cylinder that is touched in the middle of its flat face.

    ``radius``, ``length`` and the mesh size ``size`` are in m.
    """
    r, z = np.meshgrid(graded_positions(radius, size), graded_positions(length, size, NEAR / 2))
    return _grid(r, z, material)


def sphere(radius: float, material: Material, size: float = SIZE) -> Body:
    """Return the mesh of a solid sphere. ``radius`` and the mesh size ``size`` are in m.

    The sides of a square mesh are bent to a circle.
    """
    across = graded_positions(1.0, size * math.sqrt(2) / radius, NEAR * math.sqrt(2) / radius)
    along = graded_positions(2.0, size / radius, NEAR / 2 / radius)
    u, v = np.meshgrid(across, along - 1)
    # Rows that are fine at the contact become equally thick, where the corners shear them.
    v = (1 - u**2) * v + u**2 * np.linspace(-1, 1, along.size)[:, None]
    r, z = u * np.sqrt(1 - v**2 / 2), v * np.sqrt(1 - u**2 / 2)
    body = _grid(radius * r, radius * (1 + z), material)
    # The square's corners lie flat on the circle: triangles there, else steps become tiny.
    quads = body.quads.copy()
    for corner in (across.size - 1, r.size - 1):
        quads[quads == corner] = corner - 1
    used, numbers = np.unique(quads, return_inverse=True)
    return replace(body, nodes=body.nodes[used], quads=numbers.reshape(quads.shape))


def shell(radius: float, wall: float, material: Material, size: float = SIZE) -> Body:
    """Return the mesh of a hollow sphere with outer ``radius`` and thickness ``wall``, m."""
    angle, depth = np.meshgrid(
        graded_positions(math.pi, size / radius, NEAR / radius), graded_positions(wall, size)
    )
    r = (radius - depth) * np.abs(np.sin(angle))
    return _grid(r, radius - (radius - depth) * np.cos(angle), material)
