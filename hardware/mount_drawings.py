"""Drawings of the fingertip's mount, mould and jig for the build page."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import solids
from build123d import Part, Pos, Rot
from dimensions import Dimensions
from drawing import BOTTOM, TOP, Drawing, Point, View, pictured, project, section, seen

_MATERIALS = {
    "mount": "petg", "disc": "pzt", "board": "fr4", "sheet": "velostat", "pad": "silicone",
}  # fmt: skip


def parts(d: Dimensions) -> Drawing:
    """Return the picture of the parts of a fingertip above each other."""
    sheet = Drawing(760, 610, "Parts of a fingertip: pad, Velostat, board, piezo disc, mount")
    words = {
        "mount": "mount, PETG: a tray with a post;\nthe cable is tied to the tongue",
        "disc": f"PZT disc, {d.disc_diameter:g} mm",
        "board": f"board, {d.board_length:g} × {d.board_width:g} mm,\ntaxels on its upper side",
        "sheet": f"Velostat, {d.sheet_thickness:g} mm",
        "pad": f"silicone pad, {d.pad_thickness:g} mm,\nsix dimples on its underside",
    }
    for lift, (name, part) in zip((0, 7, 13, 19, 23), solids.fingertip(d).items(), strict=True):
        placed = sheet.place(pictured(Pos(0, 0, lift) * part, _MATERIALS[name]), 290, 490, 11.5)
        box = part.bounding_box()
        middle = lift + (box.min.Z + box.max.Z) / 2
        corner = box.max.X - (name == "mount"), box.min.Y, middle
        if name == "disc":
            corner = 2.0, 0.6 - d.disc_diameter / 2, middle
        point = seen(corner)
        placed.labels(510, placed.at(point)[1] + 6, [(point, words[name])])
    return sheet


def _stack(layers: list[tuple[str, float, str]]) -> tuple[View, list[tuple[Point, str]]]:
    """Return layers on each other, 0.8 mm wide, and a point in each with its words.

    Each layer has its material, its thickness and its words.
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
            (_MATERIALS[name], part, d.taxels[1][1] if name == "pad" else 0.0)
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


def _circle(x: float, y: float, radius: float) -> list[Point]:
    """Return points on a circle."""
    turns = (2 * math.pi * n / 72 for n in range(72))
    return [(x + radius * math.cos(t), y + radius * math.sin(t)) for t in turns]


def _box(x: float, y: float, width: float, height: float) -> list[Point]:
    """Return the corners of a rectangle by its middle."""
    a, b = width / 2, height / 2
    return [(x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b)]


def _foils(d: Dimensions) -> list[Point]:
    """Return the middles of the folded foils on the land."""
    count = round(d.foils)
    return [
        (d.foil_place * math.cos(t), d.foil_place * math.sin(t))
        for t in (math.pi / 2 + 2 * math.pi * n / count for n in range(count))
    ]


def _foil_step(sheet: Drawing, d: Dimensions) -> None:
    """Draw the back of the board with its foils, and the cut through one."""
    view = View(is_section=True)
    view.areas.append(("fr4", [_box(0, 0, d.board_length, d.board_width)]))
    view.areas.append(("pzt", [_circle(0, 0, d.disc_diameter / 2)]))
    view.areas += [("copper", [_box(x, y, d.foil_side, d.foil_side)]) for x, y in _foils(d)]
    v = sheet.place(view, 240, 160, 15)
    top = _foils(d)[0]
    v.labels(
        430, 70,
        [
            ((top[0] + 0.4, top[1]), f"three foils, {d.foil_side:g} × {d.foil_side:g} mm, folded"),
            ((4.2, -1.5), "land of the board"),
            ((8.5, -5.5), "back of the board"),
        ],
        36,
    )  # fmt: skip
    foil, gap, side = 0.035, d.board_glue, d.foil_side
    fold = View(is_section=True)
    for material, low, high in (
        ("fr4", -0.25, 0.0), ("glue", 0.0, gap), ("pzt", gap, gap + d.disc_thickness),
    ):  # fmt: skip
        fold.areas.append((material, [_box(0, (low + high) / 2, 2.2, high - low)]))
    middle, x = gap / 2, side / 2
    inner, outer = 0.008, 0.008 + foil
    u = [
        (-x, middle + inner), (x - foil, middle + inner), (x - foil, middle - inner),
        (-x, middle - inner), (-x, middle - outer), (x, middle - outer),
        (x, middle + outer), (-x, middle + outer),
    ]  # fmt: skip
    fold.areas.append(("copper", [u]))
    z = sheet.place(fold, 610, 245, 130)
    sheet.text(470, 190, "enlarged", "s")
    z.labels(
        775, 185,
        [
            ((1.0, gap + d.disc_thickness / 2), "disc, marked face up"),
            ((1.0, gap / 2), "silicone"),
            ((x - 0.1, middle - 0.025), "foil, adhesive outwards"),
            ((1.0, -0.15), "land"),
        ],
        27,
    )  # fmt: skip


def gluing(d: Dimensions) -> Drawing:
    """Return the picture of the three steps of gluing."""
    sheet = Drawing(980, 860, "Gluing: foils on the land, disc in the locator, board in the mount")
    face, tip = d.board_thickness, solids.fingertip(d)

    def flip(part: Part, height: float) -> Part:
        return Pos(0, 0, height) * Rot(180, 0, 0) * part

    sheet.text(40, 28, "1. Folded foils onto the land: they connect, and keep the distance", "t")
    _foil_step(sheet, d)

    sheet.text(40, 328, "2. Disc onto the back of the board, inside the locator", "t")
    disc = Pos(0, 0, face + d.board_glue - d.post_top - d.post_glue) * tip["disc"]
    locator = flip(solids.locator(d), face + d.plate)
    cut = [("petg", locator, 0.0), ("fr4", solids.board(d), 0.0), ("pzt", disc, 0.0)]
    v = sheet.place(section(cut), 330, 450, 15)
    v.labels(
        560, 375,
        [
            ((4.4, face + d.board_glue + 0.1), "disc in silicone, pressed with an eraser"),
            ((8.5, face + 1.2), "locator"),
            ((9.4, face / 2), "board, its front on paper"),
        ],
        30,
    )  # fmt: skip
    v.labels(150, 360, [((-8.0, face + 0.5), "slot for the wire")])

    sheet.text(40, 525, "3. Board onto the post of the mount, below the press", "t")
    gap = d.press_gap + d.post_glue
    press = flip(solids.press(d), d.wall_top + gap + d.press_plate)
    cut = [(_MATERIALS[name], tip[name], 0.0) for name in ("mount", "board", "disc")]
    v = sheet.place(section([*cut, ("petg", press, 0.0)]), 330, 800, 15)
    right, top = d.board_length / 2, d.wall_top + 2 * d.paper
    inside, outside = d.inner[0] / 2, d.outer[0] / 2 + 0.3
    strip = [
        (right, d.board_back), (inside, d.board_back), (inside, d.wall_top),
        (outside, d.wall_top), (outside, top), (right, top),
    ]  # fmt: skip
    sheet.place(View(areas=[("paper", [strip])], is_section=True), 330, 800, 15)
    v.labels(
        560, 565,
        [
            ((right - 2, d.wall_top + gap + 1.5), "press, with 500 g on it"),
            ((outside - 0.8, d.wall_top + gap - 0.15), "gap: paper fills it at the four corners"),
            ((right + 0.1, d.board_front - 0.4), "folded paper: keeps the board off the walls"),
            ((4.4, d.post_top + d.post_glue + 0.05), "silicone between disc and post"),
        ],
        36,
    )  # fmt: skip
    sheet.text(40, 845, "To scale, but for the foil's thickness. Cut in the middle.", "s")
    return sheet


#: Drawing of each picture of the build page.
SHEETS: dict[str, Callable[[Dimensions], Drawing]] = {
    "fingertip-parts": parts,
    "fingertip-section": assembly,
    "fingertip-mount": mount,
    "fingertip-mould": mould,
    "fingertip-gluing": gluing,
}


def write_all(d: Dimensions, folder: Path) -> None:
    """Write the drawings into a folder."""
    for name, draw in SHEETS.items():
        draw(d).write(folder / f"{name}.svg")
