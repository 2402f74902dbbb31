"""Make the fingertip's printed parts, check them, and draw them. Needs build123d.

python hardware/mount.py

Writes STEP and STL files to hardware/mount and drawings to docs/images, once all checks have
passed. The assembled fingertip goes to hardware/out. requirements-mount.txt has what to install.
"""

from __future__ import annotations

from pathlib import Path

import mesh
import mount_drawings
import numpy as np
import solids
from build123d import Box, Compound, Part, Pos, export_step
from dimensions import NOMINAL, Dimensions

ROOT = Path(__file__).resolve().parents[1]
PARTS = ROOT / "hardware/mount"
OUT = ROOT / "hardware/out"
#: STEP files name a time; with one that never changes, equal parts give equal files.
TIMESTAMP = "2026-01-01T00:00:00"


def triangles(part: Part) -> mesh.Mesh:
    """Return the surface of a part as triangles, within 0.03 mm of round faces."""
    points, corners = part.tessellate(0.03, 0.4)
    return np.array([tuple(p) for p in points])[np.array(corners)]


def check_print(name: str, surface: mesh.Mesh, d: Dimensions) -> None:
    """Raise ValueError if a part cannot be printed in its position without support."""
    if not mesh.is_watertight(surface):
        raise ValueError(f"{name}: the surface is not closed, so no printer can fill it")
    thickness, place = mesh.thinnest(surface)
    if thickness < d.thinnest - 0.01:
        x, y, z = place
        raise ValueError(
            f"{name}: a wall of {thickness:.2f} mm at ({x:.1f}, {y:.1f}, {z:.1f}) is thinner than "
            f"{d.thinnest:g} mm"
        )
    for width, is_level in mesh.overhangs(surface, d.layer):
        if not is_level:
            raise ValueError(f"{name}: a face of {width:.1f} mm leans by more than 45 degrees")
        if width > d.bridge:
            raise ValueError(f"{name}: a bridge of {width:.1f} mm is longer than {d.bridge:g} mm")


def check_clearance(mount: Part, d: Dimensions, least: float = 0.1, most: float = 0.3) -> None:
    """Raise ValueError if the gap between board and mount leaves the range, mm.

    It must be from ``least`` to ``most`` all round.
    """
    board = Pos(0, 0, d.board_back) * solids.board(d)
    size = np.array([d.board_length, d.board_width, d.board_thickness])
    middle = Pos(0, 0, d.board_back + d.board_thickness / 2)
    if _common(mount, middle * Box(*(size + 2 * least))) > 0:
        raise ValueError(f"mount: the board has less than {least:g} mm of room")
    for axis, side in ((0, -1), (0, 1), (1, -1), (1, 1)):
        shift = np.eye(3)[axis] * side * most
        if _common(mount, Pos(*shift) * board) <= 0:
            name = "xy"[axis]
            raise ValueError(
                f"mount: the gap beside the board is above {most:g} mm at {side:+d} {name}"
            )


def _common(a: Part, b: Part) -> float:
    """Return the volume that both parts fill, mm³."""
    both = a & b
    return 0.0 if both is None else sum(solid.volume for solid in both.solids())


def check_silicone(mould: Part, d: Dimensions) -> float:
    """Return the volume of both cavities, mm³. Raise ValueError if it differs from two pads."""
    height = d.pad_thickness + d.dimple_height
    filled = 0.0
    for x in (-d.mould_pitch / 2, d.mould_pitch / 2):
        cavity = Box(d.board_length, d.board_width, height)
        cavity = Pos(x, 0, d.mould_top - height / 2) * cavity
        filled += cavity.volume - _common(cavity, mould)
    expected = 2 * d.pad_volume()
    if abs(filled / expected - 1) > 0.002:
        raise ValueError(
            f"mould: holds {filled:.0f} mm³ of silicone; two pads are {expected:.0f} mm³"
        )
    return filled


def check_screws(d: Dimensions) -> None:
    """Raise ValueError if a thread comes close to the wires."""
    space = solids.cable_space(d)
    for hole in solids.screw_holes(d):
        distance = hole.distance_to(space)
        if distance < d.thinnest - 1e-6:
            raise ValueError(
                f"mount: a thread is {distance:.2f} mm from the room of the wires; "
                f"{d.thinnest:g} mm are needed"
            )


def check_press(d: Dimensions) -> None:
    """Raise ValueError if the press misses the thinnest board, or leaves no room for paper."""
    least = d.press_gap - d.board_tolerance
    if least < 2 * d.paper:
        raise ValueError(
            f"press: with the thinnest board {least:.2f} mm are left above the walls; "
            f"folded paper needs {2 * d.paper:g} mm"
        )


def check(parts: dict[str, Part], d: Dimensions) -> dict[str, mesh.Mesh]:
    """Return the surface of each part by name. Raise ValueError if one fails a check."""
    for name, part in parts.items():
        if not part.is_valid or len(part.solids()) != 1:
            raise ValueError(f"{name}: the kernel made no single valid solid")
    surfaces = {name: triangles(part) for name, part in parts.items()}
    for name, surface in surfaces.items():
        check_print(name, surface, d)
    check_clearance(parts["mount"], d)
    check_silicone(parts["mould"], d)
    check_screws(d)
    check_press(d)
    return surfaces


def main(d: Dimensions = NOMINAL) -> None:
    """Make, check and write everything."""
    parts = solids.printed(d)
    surfaces = check(parts, d)
    PARTS.mkdir(exist_ok=True)
    OUT.mkdir(exist_ok=True)
    for name, part in parts.items():
        mesh.write_stl(PARTS / f"{name}.stl", surfaces[name])
        part.label = name
        export_step(part, PARTS / f"{name}.step", write_pcurves=False, timestamp=TIMESTAMP)
        x, y, z = mesh.size(surfaces[name])
        print(f"{name}: {x:.1f} × {y:.1f} × {z:.1f} mm, {mesh.volume(surfaces[name]):.0f} mm³")
    tip = Compound(label="fingertip", children=list(solids.fingertip(d).values()))
    export_step(tip, OUT / "fingertip.step", timestamp=TIMESTAMP)
    mount_drawings.write_all(d, ROOT / "docs/images")


if __name__ == "__main__":
    main()
