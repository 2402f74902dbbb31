"""Closed surfaces of triangles: STL files, and checks for 3D printing. Lengths are in mm."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

#: Triangles, mm: one row each, of three corners. Seen from outside they turn to the left.
Mesh = NDArray[np.float64]
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(path: Path) -> Mesh:
    """Return the triangles of a binary STL file, mm."""
    data = path.read_bytes()
    records = np.frombuffer(data, _RECORD, offset=84)
    if len(records) != int.from_bytes(data[80:84], "little"):
        raise ValueError(f"{path} is damaged: its length does not fit its number of triangles")
    return records["corners"].astype(np.float64)


def write_stl(path: Path, mesh: Mesh) -> None:
    """Write a binary STL file. Equal meshes give equal files."""
    records = np.zeros(len(mesh), _RECORD)
    records["normal"], records["corners"] = _normals(mesh)[0], mesh
    header = b"firstcontact: unit mm".ljust(80) + len(mesh).to_bytes(4, "little")
    path.write_bytes(header + records.tobytes())


def _normals(mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (normals, areas) of the triangles: outward unit vectors, and mm²."""
    cross = np.cross(mesh[:, 1] - mesh[:, 0], mesh[:, 2] - mesh[:, 0])
    length = np.linalg.norm(cross, axis=1)
    return cross / np.maximum(length, 1e-12)[:, None], length / 2


def _corner_numbers(mesh: Mesh) -> NDArray[np.int64]:
    """Return the number of the point at each corner. Points within 0.1 µm have the same number."""
    _, numbers = np.unique(np.round(mesh.reshape(-1, 3), 4), axis=0, return_inverse=True)
    return numbers.reshape(-1, 3)


def is_watertight(mesh: Mesh) -> bool:
    """Return True if two triangles meet at each edge and the surface faces outwards."""
    corners = _corner_numbers(mesh)
    edges = np.concatenate([corners[:, [i, (i + 1) % 3]] for i in range(3)])
    forward = np.unique(edges, axis=0)
    backward = np.unique(edges[:, ::-1], axis=0)
    once = len(forward) == len(edges) and np.array_equal(forward, backward)
    return bool(once and volume(mesh) > 0)


def volume(mesh: Mesh) -> float:
    """Return the enclosed volume, mm³."""
    return float(np.einsum("ij,ij->", mesh[:, 0], np.cross(mesh[:, 1], mesh[:, 2]))) / 6


def size(mesh: Mesh) -> NDArray[np.float64]:
    """Return the lengths of the bounding box along x, y and z, mm."""
    points = mesh.reshape(-1, 3)
    return np.asarray(np.ptp(points, axis=0))


def _samples(mesh: Mesh, spacing: float) -> Mesh:
    """Return the mesh with its triangles divided until no side is longer than ``spacing``, mm."""
    done = []
    while len(mesh):
        sides = np.linalg.norm(mesh - np.roll(mesh, -1, axis=1), axis=2)
        longest = sides.argmax(axis=1)
        large = sides[np.arange(len(mesh)), longest] > spacing
        done.append(mesh[~large])
        turned = np.stack([np.roll(t, -i, axis=0) for t, i in zip(mesh, longest, strict=True)])
        a, b, c = turned[large].transpose(1, 0, 2)
        middle = (a + b) / 2
        mesh = np.concatenate([np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)])
    return np.concatenate(done)


def thinnest(mesh: Mesh, spacing: float = 0.8) -> tuple[float, NDArray[np.float64]]:
    """Return (thickness, point) where the solid is thinnest, mm.

    Rays go inwards, normal to the surface, from points about ``spacing`` apart. The thickness is
    the way to an opposite surface: one that faces away from the ray's start within 60 degrees.
    Otherwise each edge would count as thin.
    """
    parts = _samples(mesh, spacing)
    normals, areas = _normals(parts)
    parts, normals = parts[areas > 1e-4], normals[areas > 1e-4]
    origins = parts.mean(axis=1)
    # One of several points that are close to each other and face the same way.
    cells = np.concatenate([origins / spacing, normals * 2], axis=1).round()
    first = np.unique(cells, axis=0, return_index=True)[1]
    origins, normals = origins[first], normals[first]
    corner, u, v = mesh[:, 0], mesh[:, 1] - mesh[:, 0], mesh[:, 2] - mesh[:, 0]
    normal = np.cross(u, v)
    best, place = np.inf, origins[0]
    for chunk in np.array_split(np.arange(len(origins)), max(1, len(origins) // 500)):
        start, ray = origins[chunk, None], -normals[chunk, None]
        away = ray @ normal.T  # > 0 where the ray leaves the solid
        with np.errstate(divide="ignore", invalid="ignore"):
            way = ((corner - start) * normal).sum(axis=2) / away[:, 0]
            hit = start + way[:, :, None] * ray - corner
            area = (normal**2).sum(axis=1)
            p = (np.cross(hit, v) * normal).sum(axis=2) / area
            q = (np.cross(u, hit) * normal).sum(axis=2) / area
            inside = (p >= 0) & (q >= 0) & (p + q <= 1) & (away[:, 0] > 1e-9) & (way > 1e-6)
        way = np.where(inside, way, np.inf)
        exit_ = way.argmin(axis=1)
        rows = np.arange(len(chunk))
        opposite = away[rows, 0, exit_] > 0.5 * np.linalg.norm(normal[exit_], axis=1)
        way = np.where(opposite, way[rows, exit_], np.inf)
        if way.min() < best:
            best, place = float(way.min()), origins[chunk[way.argmin()]]
    return best, place


def overhangs(mesh: Mesh, layer: float = 0.2, degrees: float = 45.0) -> list[tuple[float, bool]]:
    """Return (width, is level) of each region that hangs over without support; mm.

    The print begins at the lowest point. Faces that lean by at most ``degrees`` from the vertical
    need no support; 2 degrees more are allowed, since triangles of round faces lean differently. So
    are faces within the first layer. The width is the least extent of a region seen from above.
    """
    normals, areas = _normals(mesh)
    lowest = mesh[:, :, 2].min()
    hangs = (normals[:, 2] < -np.sin(np.radians(degrees + 2))) & (areas > 1e-6)
    hangs &= mesh[:, :, 2].max(axis=1) > lowest + layer + 1e-3
    if not hangs.any():
        return []
    corners, points = _corner_numbers(mesh)[hangs], mesh[hangs]
    row = np.repeat(corners[:, 0], 3)
    shape = (corners.max() + 1,) * 2
    links = coo_array((np.ones(len(row)), (row, corners.ravel())), shape)
    regions = connected_components(links, directed=False)[1][corners[:, 0]]
    angles = np.radians(np.arange(0, 180, 5))
    directions = np.stack([np.cos(angles), np.sin(angles)])
    return [
        (
            float(
                np.ptp(points[regions == region].reshape(-1, 3)[:, :2] @ directions, axis=0).min()
            ),
            bool((normals[hangs][regions == region, 2] < -0.99).all()),
        )
        for region in np.unique(regions)
    ]
