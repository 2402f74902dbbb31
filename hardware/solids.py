"""Solids of the fingertip, made with build123d from the table of dimensions.

Parts to print stand on z = 0 in their position for printing. ``fingertip`` puts them together.
"""

from __future__ import annotations

import math

from build123d import (
    Align,
    Axis,
    Box,
    Cone,
    Cylinder,
    GeomType,
    Part,
    Plane,
    Pos,
    Rectangle,
    RectangleRounded,
    chamfer,
    extrude,
    fillet,
)
from dimensions import Dimensions

_UP = (Align.CENTER, Align.CENTER, Align.MIN)
_DOWN = (Align.CENTER, Align.CENTER, Align.MAX)
#: What is cut off begins or ends this far outside of a solid.
_BEYOND = 1.0


def _box(x0: float, x1: float, width: float, z0: float, z1: float, y: float = 0.0) -> Part:
    """Return a box from ``x0`` to ``x1`` and from ``z0`` to ``z1``, centred on ``y``, mm."""
    box = Box(x1 - x0, width, z1 - z0, align=_UP)
    return Pos((x0 + x1) / 2, y, z0) * box


def board(d: Dimensions) -> Part:
    """Return the board with the force array; its back lies on z = 0."""
    return Box(d.board_length, d.board_width, d.board_thickness, align=_UP)


def pad(d: Dimensions) -> Part:
    """Return the silicone pad: its underside on z = 0, its dimples below."""
    face = Plane.XY.offset(d.pad_thickness) * Rectangle(d.board_length, d.board_width)
    body = extrude(face, -d.pad_thickness, taper=d.draft)
    end = d.dimple_diameter / 2
    root = end + d.dimple_height * math.tan(math.radians(d.draft))
    dimple = Cone(end, root, d.dimple_height, align=_DOWN)
    for x, y in d.taxels:
        body += Pos(x, y, 0) * dimple
    return body


def disc(d: Dimensions) -> Part:
    """Return the piezo disc, on z = 0."""
    return Cylinder(d.disc_diameter / 2, d.disc_thickness, align=_UP)


def sheet(d: Dimensions) -> Part:
    """Return the sheet of Velostat, on z = 0."""
    outline = Rectangle(d.sheet_length, d.sheet_width)
    return extrude(chamfer(outline.vertices(), d.sheet_cut), d.sheet_thickness)


def screw_holes(d: Dimensions) -> list[Part]:
    """Return the holes of the screws, to be cut out of the mount."""
    hole = Cylinder(d.insert_diameter / 2, d.insert_depth, align=_UP)
    return [Pos(x, y, 0) * hole for x, y in d.screws]


def cable_space(d: Dimensions) -> Part:
    """Return the space for wires and cable tie: tray, opening, slots and groove."""
    start, tie = -d.outer[0] / 2, -d.outer[0] / 2 - d.tongue_length / 2
    top = d.wall_top + _BEYOND
    space = _box(-d.inner[0] / 2, d.inner[0] / 2, d.inner[1], d.floor, top)
    space += _box(start - d.tongue_length, 0, d.cable_width, d.floor, top)
    x0, x1 = tie - d.tie_width / 2, tie + d.tie_width / 2
    for y in (-d.tie_spacing / 2, d.tie_spacing / 2):
        space += _box(x0, x1, d.tie_thickness, -_BEYOND, d.floor + _BEYOND, y)
    return space + _box(x0, x1, d.tie_spacing + d.tie_thickness, -_BEYOND, d.tie_thickness)


def mount(d: Dimensions) -> Part:
    """Return the mount: a tray with a post, threads in its flat back, and a tongue."""
    start = -d.outer[0] / 2
    tray = RectangleRounded(*d.outer, radius=d.wall)
    outline = tray + Pos(start, 0) * Rectangle(2 * d.tongue_length, d.tongue_width)
    bends = [v for v in outline.vertices() if abs(v.X - start) < 0.01]
    outline = fillet(bends, 0.6)
    outline = fillet(outline.vertices().group_by(Axis.X)[0], 2.0)
    base = extrude(outline, d.floor)
    base = chamfer(base.faces().sort_by(Axis.Z)[0].edges(), d.edge)
    tongue = [e for e in base.faces().sort_by(Axis.Z)[-1].edges() if start - e.center().X > 0.5]
    base = chamfer(tongue, d.edge)
    walls = extrude(tray, d.wall_top)
    walls = chamfer(walls.faces().sort_by(Axis.Z)[-1].edges(), d.edge)
    walls -= Box(*d.outer, d.floor / 2, align=_UP)
    walls -= cable_space(d)
    opening = [
        e for e in walls.edges().filter_by(Axis.Z)
        if abs(abs(e.center().Y) - d.cable_width / 2) < 0.01
    ]  # fmt: skip
    solid = base + fillet(opening, 0.375 * d.wall) - cable_space(d)
    solid += Pos(0, 0, d.floor) * Cylinder(d.disc_diameter / 2, d.post_height, align=_UP)
    foot = [
        e for e in solid.edges().filter_by(GeomType.CIRCLE)
        if abs(e.center().Z - d.floor) < 0.01 and abs(e.radius - d.disc_diameter / 2) < 0.01
    ]  # fmt: skip
    solid = fillet(foot, 0.8)
    edge = -d.disc_diameter / 2
    step = d.post_top - d.joint_depth
    solid -= _box(edge - _BEYOND, edge + d.joint_length, d.disc_diameter, step, d.post_top)
    lead = Cone(d.insert_diameter / 2 + d.edge, d.insert_diameter / 2, d.edge, align=_UP)
    for hole, (x, y) in zip(screw_holes(d), d.screws, strict=True):
        solid = solid - hole - Pos(x, y, 0) * lead
    return solid


def mould(d: Dimensions) -> Part:
    """Return the open mould with the cavities of two pads, each inside its rim."""
    length = 2 * d.board_length + 4 * d.land + 3 * d.gutter + 2 * d.wall
    width = d.board_width + 2 * (d.land + d.gutter + d.wall)
    solid = extrude(RectangleRounded(length, width, radius=3.0), d.mould_top - d.border_drop)
    solid = chamfer(solid.faces().sort_by(Axis.Z)[0].edges(), d.edge)
    bottom = d.mould_top - d.gutter_depth
    gutter = RectangleRounded(length - 2 * d.wall, width - 2 * d.wall, radius=3.0 - d.wall)
    solid -= Pos(0, 0, bottom) * extrude(gutter, d.gutter_depth)
    rim = Rectangle(d.board_length + 2 * d.land, d.board_width + 2 * d.land)
    for x in (-d.mould_pitch / 2, d.mould_pitch / 2):
        solid += Pos(x, 0, bottom - _BEYOND) * extrude(rim, d.gutter_depth + _BEYOND)
    for x in (-d.mould_pitch / 2, d.mould_pitch / 2):
        solid -= Pos(x, 0, d.mould_top - d.pad_thickness) * pad(d)
    return solid


def locator(d: Dimensions) -> Part:
    """Return the jig that centres the disc on the board's back, with its plate on z = 0."""
    inner = d.board_length + 2 * d.board_fit, d.board_width + 2 * d.board_fit
    outer = inner[0] + 2 * d.wall, inner[1] + 2 * d.wall
    solid = extrude(RectangleRounded(*outer, radius=d.wall), d.plate + d.locator_depth)
    solid = chamfer(solid.faces().sort_by(Axis.Z)[0].edges(), d.edge)
    solid -= Pos(0, 0, d.plate) * Box(*inner, d.locator_depth + _BEYOND, align=_UP)
    radius = d.disc_diameter / 2 + d.disc_fit
    hole = Cylinder(radius, d.plate, align=_UP)
    hole += Pos(0, 0, d.plate - d.squeeze) * Cone(radius, radius + d.squeeze, d.squeeze, align=_UP)
    slot = _box(-outer[0] / 2 - _BEYOND, 0, d.slot, -_BEYOND, d.plate + d.locator_depth)
    return solid - hole - slot


def press(d: Dimensions) -> Part:
    """Return the jig that presses the board onto the post, with its plate on z = 0."""
    solid = extrude(RectangleRounded(*d.outer, radius=d.wall), d.press_plate)
    solid = chamfer(solid.faces().sort_by(Axis.Z)[0].edges(), d.edge)
    face = Rectangle(d.board_length - 2 * d.press_margin, d.board_width - 2 * d.press_margin)
    return solid + extrude(face, d.press_plate + d.press_drop)


def printed(d: Dimensions) -> dict[str, Part]:
    """Return the parts to print, in their position for printing, by file name."""
    return {"mount": mount(d), "mould": mould(d), "locator": locator(d), "press": press(d)}


def fingertip(d: Dimensions) -> dict[str, Part]:
    """Return the parts of one fingertip in place, by name, from the mount to the pad."""
    return {
        "mount": mount(d),
        "disc": Pos(0, 0, d.post_top + d.post_glue) * disc(d),
        "board": Pos(0, 0, d.board_back) * board(d),
        "sheet": Pos(0, 0, d.board_front) * sheet(d),
        "pad": Pos(0, 0, d.pad_bottom) * pad(d),
    }
