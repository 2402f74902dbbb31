"""Drawings of the fingertip's parts, mount and mould for the build page."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import adapter
import solids
from build123d import Pos
from dimensions import Dimensions
from drawing import (
    BOTTOM,
    MATERIALS,
    TOP,
    Drawing,
    Point,
    View,
    pictured,
    project,
    section,
    seen,
)
from gluing_drawings import STEPS


def parts(d: Dimensions) -> Drawing:
    """Return the exploded view of a fingertip: its parts above each other."""
    sheet = Drawing(760, 610, "Parts of a fingertip: pad, Velostat, board, piezo disc, mount")
    words = {
        "mount": "mount, PETG: a tray with a post;\nthe cable is tied to the tongue",
        "disc": f"PZT disc, {d.disc_diameter:g} mm",
        "board": f"board, {d.board_length:g} × {d.board_width:g} mm,\ntaxels on its upper side",
        "sheet": f"Velostat, {d.sheet_thickness:g} mm",
        "pad": f"silicone pad, {d.pad_thickness:g} mm,\nsix dimples on its underside",
    }
    for lift, (name, part) in zip((0, 7, 13, 19, 23), solids.fingertip(d).items(), strict=True):
        placed = sheet.place(pictured(Pos(0, 0, lift) * part, MATERIALS[name]), 290, 490, 11.5)
        box = part.bounding_box()
        middle = lift + (box.min.Z + box.max.Z) / 2
        corner = box.max.X - (name == "mount"), box.min.Y, middle
        if name == "disc":
            corner = 2.0, 0.6 - d.disc_diameter / 2, middle
        point = seen(corner)
        placed.labels(510, placed.at(point)[1] + 6, [(point, words[name])])
    return sheet


def _stack(layers: list[tuple[str, float, str]]) -> tuple[View, list[tuple[Point, str]]]:
    """Return a section of layers on each other, 0.8 mm wide, and a labelled point in each.

    A layer is (material, thickness, label), mm.
    """
    view, points, z = View(is_section=True), [], 0.0
    for material, thickness, words in layers:
        top = z + thickness
        view.areas.append((material, [[(0.0, z), (0.8, z), (0.8, top), (0.0, top)]]))
        points.append(((0.7, (z + top) / 2), words))
        z = top
    return view, points


def assembly(d: Dimensions) -> Drawing:
    """Return the section through the assembled fingertip, to scale."""
    title = "Section through a fingertip: pad, Velostat, board, piezo disc on a post, mount"
    sheet = Drawing(980, 480, title)
    s = sheet.place(
        section(
            (MATERIALS[name], part, d.taxels[1][1] if name == "pad" else 0.0)
            for name, part in solids.fingertip(d).items()
        ),
        440, 330, 19,
    )  # fmt: skip
    right, last = d.board_length / 2, d.taxels[-1][0]
    s.labels(
        700, 60,
        [
            ((right - 0.8, d.pad_top - 0.9), "silicone pad, 65 Shore A"),
            ((last + 0.6, d.pad_bottom - 0.2), "six dimples, one over each taxel"),
            ((right - 1.2, d.board_front + 0.05), f"Velostat, {d.sheet_thickness:g} mm"),
            ((right - 0.8, d.board_back + 0.8), f"board; {d.clearance:g} mm around it are free"),
            ((4.4, d.post_top + d.post_glue + 0.05), "PZT disc in silicone, on the post"),
            ((3.6, d.post_top - 1.6), "post of the mount"),
            ((right + 0.7, d.floor - 1.6), "mount, PETG, screwed to the finger"),
        ],
        27,
    )  # fmt: skip
    tie = -d.outer[0] / 2 - d.tongue_length / 2
    s.labels(186, 140, [((-6.6, d.floor + 1.0), "room for nine wires")])
    s.labels(170, 372, [((tie, d.tie_thickness / 2), "groove and slots for a cable tie")])
    s.width(-right, right, d.pad_top, d.pad_top + 1.3)
    s.height(0, d.pad_top, -right, -right - 12)
    s.height(d.pad_bottom, d.pad_top, -right, -right - 1.6)
    layers = [
        ("petg", 0.25, "post"),
        ("glue", d.post_glue, f"silicone, about {d.post_glue:g} mm"),
        ("pzt", d.disc_thickness, f"disc, {d.disc_thickness:g} mm"),
        ("glue", d.board_glue, f"silicone with foil, about {d.board_glue:g} mm"),
        ("fr4", 0.25, "board"),
    ]
    stack, points = _stack(layers)
    zoom = sheet.place(stack, 560, 460, 130)
    zoom.labels(700, 375, points[::-1], 20)
    sheet.text(545, 400, "enlarged", "s", "end")
    sheet.text(
        40, 465, "To scale, in mm. Pad cut through a row of dimples, all else in the middle.", "s"
    )
    return sheet


def mount(d: Dimensions) -> Drawing:
    """Return the drawing of the mount."""
    sheet = Drawing(980, 720, "Mount: four views with dimensions in mm")
    part = solids.mount(d)
    (length, width), (inner, inside) = d.outer, d.inner
    x, end = length / 2, -length / 2 - d.tongue_length
    tie = -x - d.tongue_length / 2

    sheet.text(40, 28, "From above", "t")
    v = sheet.place(project(part, TOP), 330, 190, 12)
    v.centre((0, 0), x + 1, width / 2 + 1)
    v.width(end, x, -width / 2, -width / 2 - 3.4)
    v.width(-x, x, -width / 2, -width / 2 - 1.5)
    v.width(-inner / 2, inner / 2, width / 2, width / 2 + 1.2)
    v.height(-width / 2, width / 2, x, x + 4)
    v.height(-inside / 2, inside / 2, x, x + 1.4)
    v.height(-d.tongue_width / 2, d.tongue_width / 2, end, end - 3.6)
    v.height(-d.cable_width / 2, d.cable_width / 2, -x, end - 1.3)
    v.label((3.54, 3.54), f"Ø{d.disc_diameter:g}", 20, -20)

    sheet.text(40, 370, "Section through the middle", "t")
    v = sheet.place(section([("petg", part, 0.0)]), 330, 565, 12)
    v.height(0, d.floor, end, end - 1.5)
    v.height(0, d.wall_top, x, x + 1.5)
    v.height(0, d.post_top, x, x + 5)
    v.height(d.floor, d.post_top, d.disc_diameter / 2, 6.6)
    radius = d.disc_diameter / 2
    v.width(-radius, -radius + d.joint_length, d.post_top, d.post_top + 1.2)
    v.height(d.post_top - d.joint_depth, d.post_top, -radius, -radius - 2.2)
    v.width(inner / 2, x, d.wall_top, d.wall_top + 1.0)
    v.width(end, -x, 0, -2)
    v.height(0, d.tie_thickness, tie, tie + 5)

    sheet.text(600, 28, "Back, towards the hand: flat", "t")
    v = sheet.place(project(part, BOTTOM), 710, 190, 12)
    a, b = d.screw_length / 2, d.screw_width / 2
    for sx, sy in d.screws:
        v.centre((-sx, sy), 2.4, 2.4)
    v.width(-a, a, b, width / 2 + 1.2)
    v.height(-b, b, -a, -x - 1.6)
    v.width(-x, -a, -b, -width / 2 - 1.4)
    v.height(-d.tie_spacing / 2, d.tie_spacing / 2, -tie, -end + 1.4)
    v.width(
        -tie - d.tie_width / 2, -tie + d.tie_width / 2, d.tie_spacing / 2, d.tongue_width / 2 + 1.4
    )
    v.label(
        (a - d.insert_diameter / 2 * 0.7, -b - d.insert_diameter / 2 * 0.7),
        f"4 × Ø{d.insert_diameter:g}, {d.insert_depth:g} deep:\nheat-set insert M2 × 3", -40, 74,
    )  # fmt: skip
    sheet.place(pictured(part, "petg"), 760, 600, 9.5)
    sheet.text(
        40, 700, "Lengths in mm. Printed as in the section, on its back, without support.", "s"
    )
    return sheet


def mould(d: Dimensions) -> Drawing:
    """Return the drawing of the mould."""
    sheet = Drawing(1000, 620, "Mould for two pads: three views with dimensions in mm")
    part = solids.mould(d)
    box = part.bounding_box()
    length, width = box.size.X, box.size.Y
    middle, pad = d.mould_pitch / 2, d.board_length / 2

    sheet.text(40, 28, "From above", "t")
    v = sheet.place(project(part, TOP), 350, 200, 10)
    v.width(-length / 2, length / 2, -width / 2, -width / 2 - 4)
    v.width(-middle - pad, -middle + pad, width / 2, width / 2 + 1.4)
    v.width(middle - pad - d.land, middle - pad, width / 2, width / 2 + 1.4)
    v.height(-width / 2, width / 2, length / 2, length / 2 + 5)
    v.height(-d.board_width / 2, d.board_width / 2, length / 2, length / 2 + 2.2)
    columns = sorted({y for _, y in d.taxels})
    rows = sorted({x for x, _ in d.taxels})
    for x, y in d.taxels:
        v.centre((middle + x, y), 2, 2)
        v.centre((-middle + x, y), 2, 2)
    v.height(columns[0], columns[1], -length / 2, -length / 2 - 4)
    v.width(
        -middle + rows[0],
        -middle + rows[1],
        -width / 2,
        -width / 2 - 1.8,
        f"{rows[1] - rows[0]:.2f}",
    )

    sheet.text(40, 415, "Section through a row of dimples", "t")
    v = sheet.place(section([("petg", part, columns[1])]), 350, 530, 10)
    floor = d.mould_top - d.pad_thickness
    v.height(floor, d.mould_top, length / 2, length / 2 + 5)
    v.height(d.mould_floor, floor, length / 2, length / 2 + 1.2)
    v.height(0, d.mould_top, -length / 2, -length / 2 - 2)
    x = -middle + rows[0]
    v.width(
        x - d.dimple_diameter / 2,
        x + d.dimple_diameter / 2,
        d.mould_floor,
        -2.2,
        f"Ø{d.dimple_diameter:g}",
    )
    sheet.place(pictured(part, "petg"), 850, 310, 5)
    sheet.text(
        40, 605,
        f"Lengths in mm, of the cavity at its upper edge. Sides and dimples have a draft of "
        f"{d.draft:g}°.",
        "s",
    )  # fmt: skip
    return sheet


#: Drawing of each picture of the build page.
SHEETS: dict[str, Callable[[Dimensions], Drawing]] = {
    "fingertip-parts": parts,
    "fingertip-section": assembly,
    "fingertip-mount": mount,
    "fingertip-mould": mould,
    "fingertip-adapter": adapter.drawing,
    **STEPS,
}


def write_all(d: Dimensions, folder: Path) -> None:
    """Write all drawings as SVG files into a folder."""
    for name, draw in SHEETS.items():
        draw(d).write(folder / f"{name}.svg")
