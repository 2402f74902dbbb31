"""Pictures of the gluing for the build page, one per step."""

from __future__ import annotations

import math
from collections.abc import Callable

import solids
from build123d import Part, Pos, Rot
from dimensions import Dimensions
from drawing import MATERIALS, TOP, Drawing, Line, Placed, Point, View, pictured, project, section
from fingertip_layout import (
    COLUMNS,
    DISC_WIRE,
    DISC_WIRE_SIDE,
    ROWS,
    WIRE_PAD,
    WIRES_PITCH,
    WIRES_X,
    comb,
    taxel_center,
)


def _circle(x: float, y: float, radius: float) -> Line:
    """Return points on a circle."""
    turns = (2 * math.pi * n / 72 for n in range(72))
    return [(x + radius * math.cos(t), y + radius * math.sin(t)) for t in turns]


def _box(x: float, y: float, width: float, height: float) -> Line:
    """Return the corners of a rectangle by its middle."""
    a, b = width / 2, height / 2
    return [(x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b)]


def _drop(x: float, z: float, width: float, height: float) -> Line:
    """Return the outline of a drop in a section. It lies at the height ``z``."""
    turns = (math.pi * n / 24 for n in range(25))
    return [(x + width / 2 * math.cos(t), z + height * math.sin(t)) for t in turns]


def _flip(part: Part, height: float) -> Part:
    """Return a part upside down, with its former underside at ``height``."""
    return Pos(0, 0, height) * Rot(180, 0, 0) * part


def _areas(*areas: tuple[str, Line]) -> View:
    """Return filled outlines, each with its material."""
    return View(areas=[(material, [outline]) for material, outline in areas], is_section=True)


def _down(placed: Placed, x: float, top: float, bottom: float) -> None:
    """Add an arrow that points down."""
    start, end = placed.at((x, top)), placed.at((x, bottom))
    placed.drawing.line([start, end], "d")
    placed.drawing.arrow(end, math.pi / 2)


def _foil_places(d: Dimensions) -> list[Point]:
    """Return the middles of the folded foils on the land."""
    count = round(d.foils)
    return [
        (d.foil_place * math.cos(t), d.foil_place * math.sin(t))
        for t in (math.pi / 2 + 2 * math.pi * n / count for n in range(count))
    ]


def _land(d: Dimensions) -> View:
    """Return a view of the board's back with its pads and the foils. The cable is to the left."""
    return _areas(
        ("fr4", _box(0, 0, d.board_length, d.board_width)),
        ("gold", _circle(0, 0, d.disc_diameter / 2)),
        ("gold", _circle(*DISC_WIRE, DISC_WIRE_SIDE / 2)),
        *(("gold", _box(WIRES_X, n * WIRES_PITCH, *WIRE_PAD)) for n in range(-4, 5)),
        *(("copper", _box(x, y, d.foil_side, d.foil_side)) for x, y in _foil_places(d)),
    )


def foils(d: Dimensions) -> Drawing:
    """Return the picture of the folded foils on the board's land."""
    sheet = Drawing(980, 310, "Three folded foils on the land of the board")
    v = sheet.place(_land(d), 240, 155, 15)
    top = _foil_places(d)[0]
    v.labels(
        430, 60,
        [
            ((top[0] + 0.4, top[1]), f"three foils, {d.foil_side:g} × {d.foil_side:g} mm, folded"),
            ((4.2, -1.5), "land of the board"),
            ((8.5, -5.5), "back of the board, its cable to the left"),
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
    sheet.text(470, 190, "Cut through a foil, enlarged", "s")
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
    return sheet


def silicone(d: Dimensions) -> Drawing:
    """Return the picture of the locator on the board, with the drop of silicone."""
    sheet = Drawing(980, 350, "Locator over the board, and a drop of silicone on the land")
    face = d.board_thickness
    locator = _flip(solids.locator(d), face + d.plate)
    sheet.text(40, 28, "From above", "t")
    sheet.place(_land(d), 190, 185, 13)
    sheet.place(pictured(locator, "petg", TOP), 190, 185, 13)
    v = sheet.place(_areas(("glue", _circle(0, 0, 2.0))), 190, 185, 13)
    v.labels(
        365, 60,
        [
            ((1.2, 1.2), "drop of silicone, 4 mm"),
            ((9.0, 6.0), "locator, over the board"),
        ],
        30,
    )  # fmt: skip
    v.labels(365, 270, [((_foil_places(d)[2][0], -1.5), "foil: keep it free")])
    v.label((-9.5, -1.0), "slot, over the pads of the wires", 12, 135)
    sheet.text(560, 28, "Cut in the middle", "t")
    cut = [("petg", locator, 0.0), ("fr4", solids.board(d), 0.0)]
    sheet.place(section(cut), 710, 240, 13)
    v = sheet.place(_areas(("glue", _drop(0, face, 4.0, 0.9))), 710, 240, 13)
    v.labels(
        830, 110,
        [((0.6, face + 0.5), "silicone"), ((8.5, face + 1.2), "locator")], 30,
    )  # fmt: skip
    v.labels(830, 290, [((9.4, face / 2), "board, front\non paper")])
    return sheet


def disc(d: Dimensions) -> Drawing:
    """Return the picture of the disc in the locator."""
    sheet = Drawing(980, 350, "Disc in the locator, pressed with an eraser")
    face = d.board_thickness
    locator = _flip(solids.locator(d), face + d.plate)
    joint = (-d.disc_diameter / 2 + 1.0, 0.0)
    sheet.text(40, 28, "From above", "t")
    sheet.place(_land(d), 190, 185, 13)
    sheet.place(pictured(locator, "petg", TOP), 190, 185, 13)
    wire = [(joint[0], -0.15), (-14.0, -0.15), (-14.0, 0.15), (joint[0], 0.15)]
    v = sheet.place(
        _areas(
            ("pzt", _circle(0, 0, d.disc_diameter / 2)),
            ("copper", wire),
            ("paper", _circle(*joint, 0.7)),
        ),
        190, 185, 13,
    )  # fmt: skip
    v.labels(365, 75, [((2.5, 2.5), "disc, marked face up")])
    v.label((joint[0], -0.4), "solder joint and wire, at the slot", 25, 135)
    sheet.text(560, 28, "Cut in the middle", "t")
    z = face + d.board_glue
    lying = Pos(0, 0, z) * solids.disc(d)
    cut = [("petg", locator, 0.0), ("fr4", solids.board(d), 0.0), ("pzt", lying, 0.0)]
    sheet.place(section(cut), 710, 240, 13)
    top, right = z + d.disc_thickness, 4.4
    notch = joint[0] + 1.6
    eraser = [(notch, top), (right, top), (right, top + 5), (-right, top + 5),
              (-right, top + 1.6), (notch, top + 1.6)]  # fmt: skip
    v = sheet.place(
        _areas(
            ("glue", _box(0, face + d.board_glue / 2, d.disc_diameter, d.board_glue)),
            ("silicone", eraser),
            ("paper", _drop(joint[0], top, 1.4, 0.7)),
        ),
        710, 240, 13,
    )  # fmt: skip
    _down(v, 0, top + 9, top + 5.1)
    v.labels(
        830, 100,
        [
            ((right - 0.6, top + 4), "eraser, 200 g"),
            ((4.6, face + d.board_glue + 0.1), "disc"),
            ((4.9, face + d.board_glue / 2), "silicone"),
        ],
        34,
    )  # fmt: skip
    v.label((joint[0], top + 0.4), "joint: eraser\ncut out", -40, 90)
    return sheet


def _strips(d: Dimensions) -> list[Line]:
    """Return the outlines of the paper strips that hang over the walls, seen from above."""
    wide, long = 3.0, d.clearance + d.wall + 1.5
    y = d.board_width / 2 + long / 2
    x = d.board_length / 2 + long / 2
    return [
        *(_box(at, side * y, wide, long) for at in (-6.0, 6.0) for side in (-1, 1)),
        _box(x, 0, long, wide),
    ]


def _hanging(d: Dimensions) -> Line:
    """Return the outline of the paper strip over the wall at the tip, in a section."""
    right, top = d.board_length / 2, d.wall_top + 2 * d.paper
    inside, outside = d.inner[0] / 2, d.outer[0] / 2 + 0.3
    return [
        (right, d.board_back), (inside, d.board_back), (inside, d.wall_top),
        (outside, d.wall_top), (outside, top), (right, top),
    ]  # fmt: skip


def fitting(d: Dimensions) -> Drawing:
    """Return the picture of the board in the mount without glue."""
    sheet = Drawing(980, 660, "Board in the mount without glue: strips of paper, and the press")
    tip, gap = solids.fingertip(d), d.press_gap + d.post_glue
    sheet.text(40, 28, "From above, without the press", "t")
    board = _areas(("fr4", _box(0, 0, d.board_length, d.board_width)))
    sheet.place(project(tip["mount"], TOP), 330, 188, 13)
    sheet.place(board, 330, 188, 13)
    v = sheet.place(_areas(*(("paper", strip) for strip in _strips(d))), 330, 188, 13)
    v.labels(
        560, 70,
        [
            ((6.5, d.board_width / 2 + 1.5), "folded paper: two over each long wall,"),
            ((d.board_length / 2 + 1.5, 0.6), "one over the wall at the tip"),
            ((7.5, -4.5), "board, its combs up, against the strip at the tip"),
        ],
        40,
    )  # fmt: skip
    sheet.text(40, 345, "Cut in the middle, with the press", "t")
    press = _flip(solids.press(d), d.wall_top + gap + d.press_plate)
    cut = [(MATERIALS[name], tip[name], 0.0) for name in ("mount", "disc", "board")]
    sheet.place(section([*cut, ("petg", press, 0.0)]), 330, 620, 15)
    edge = d.outer[0] / 2
    sheets = _box(-edge + 1.2, d.wall_top + gap / 2, 2.4, gap)
    other = _box(edge - 1.0, d.wall_top + gap / 2 + d.paper, 2.0, gap - 2 * d.paper)
    v = sheet.place(
        _areas(("paper", _hanging(d)), ("paper", sheets), ("paper", other)), 330, 620, 15
    )
    v.labels(
        560, 395,
        [
            ((d.board_length / 2 - 2, d.wall_top + gap + 1.5), "press"),
            ((edge - 0.6, d.wall_top + gap / 2 + 0.1), "paper at the four corners"),
            ((d.board_length / 2 + 0.1, d.board_front - 0.4), "folded paper"),
        ],
        34,
    )  # fmt: skip
    return sheet


def board(d: Dimensions) -> Drawing:
    """Return the picture of the board that is glued to the post."""
    sheet = Drawing(980, 420, "Drop of silicone on the post, then board, strips of paper and press")
    tip, gap, lift = solids.fingertip(d), d.press_gap + d.post_glue, 3.6
    press = _flip(solids.press(d), d.wall_top + gap + d.press_plate + 2 * lift)
    cut = [
        ("petg", tip["mount"], 0.0), ("pzt", Pos(0, 0, lift) * tip["disc"], 0.0),
        ("fr4", Pos(0, 0, lift) * tip["board"], 0.0), ("petg", press, 0.0),
    ]  # fmt: skip
    sheet.place(section(cut), 330, 385, 15)
    z = d.board_back + lift
    held = _box(0, z - d.board_glue / 2, d.disc_diameter, d.board_glue)
    v = sheet.place(
        _areas(
            ("glue", _drop(0.6, d.post_top, 4.0, 1.0)), ("glue", held), ("paper", _hanging(d)),
        ),
        330, 385, 15,
    )  # fmt: skip
    _down(v, -7, z - 0.4, z - 2.6)
    top = d.wall_top + gap + d.press_plate + 2 * lift
    _down(v, 0, top + 2.4, top + 0.2)
    v.labels(
        560, 60,
        [
            ((d.outer[0] / 2 - 2, top - 1.5), "3. press with its paper, and 500 g on it"),
            ((d.board_length / 2 - 0.8, z + 0.8), "2. board with its disc"),
            ((d.outer[0] / 2, d.wall_top + d.paper), "folded paper: pull it out when firm"),
            ((2.0, d.post_top + 0.4), "1. drop of silicone, on the middle of the post"),
        ],
        44,
    )  # fmt: skip
    return sheet


def sheet_of_velostat(d: Dimensions) -> Drawing:
    """Return the picture of the Velostat on the combs."""
    sheet = Drawing(980, 360, "Velostat on the combs, held by two tapes")
    view = _areas(("fr4", _box(0, 0, d.board_length, d.board_width)))
    for row in range(ROWS):
        for column in range(COLUMNS):
            x, y = taxel_center(row, column)
            turn = 1 - 2 * column
            for kind in ("row", "column"):
                outline = [(x + turn * a, -(y + turn * b)) for a, b in comb(kind)]
                view.areas.append(("gold", [outline]))
    v = sheet.place(view, 260, 180, 20)
    a, b, cut = d.sheet_length / 2, d.sheet_width / 2, d.sheet_cut
    edge = [
        (-a + cut, -b), (a - cut, -b), (a, -b + cut), (a, b - cut), (a - cut, b), (-a + cut, b),
        (-a, b - cut), (-a, -b + cut), (-a + cut, -b),
    ]  # fmt: skip
    sheet.place(View(areas=[("velostat", [edge])], is_section=True, opacity=0.55), 260, 180, 20)
    tapes = [("paper", _box(0, s * b, d.tape_length, d.tape_width)) for s in (-1, 1)]
    sheet.place(_areas(*tapes), 260, 180, 20)
    v.labels(
        500, 60,
        [
            ((4.6, b), f"thin tape, {d.tape_width:g} × {d.tape_length:g} mm, half on the sheet"),
            ((a - cut / 2, b - cut / 2), f"corners cut off by {cut:g} mm"),
            ((8.0, 4.0), f"Velostat, {d.sheet_length:g} × {d.sheet_width:g} mm, over all combs"),
            ((9.8, -6.0), "edge of the board: stays free"),
        ],
        50,
    )  # fmt: skip
    return sheet


def pad(d: Dimensions) -> Drawing:
    """Return the picture of the pad that is glued to the board."""
    sheet = Drawing(980, 660, "Pad on the corners of the board, and the cable in its tie")
    tip, lift = solids.fingertip(d), 3.0
    row = d.taxels[1][1]
    sheet.text(40, 28, "From above, without the pad", "t")
    sheet.place(project(tip["mount"], TOP), 330, 188, 13)
    corners = [
        _circle(x * (d.board_length / 2 - 0.7), y * (d.board_width / 2 - 0.7), 0.6)
        for x in (-1, 1)
        for y in (-1, 1)
    ]
    v = sheet.place(
        _areas(
            ("fr4", _box(0, 0, d.board_length, d.board_width)),
            ("velostat", _box(0, 0, d.sheet_length, d.sheet_width)),
            *(("glue", corner) for corner in corners),
        ),
        330, 188, 13,
    )  # fmt: skip
    v.labels(
        560, 70,
        [
            ((d.board_length / 2 - 0.5, d.board_width / 2 - 0.5), "dab of silicone, one a corner"),
            ((d.inner[0] / 2 - 0.1, -3.0), "gap: nothing between pad and walls"),
        ],
        40,
    )  # fmt: skip
    sheet.text(40, 345, "Cut through a row of dimples", "t")
    names = ("mount", "disc", "board", "sheet")
    cut = [(MATERIALS[name], tip[name], 0.0) for name in names]
    cut.append(("silicone", Pos(0, 0, lift) * tip["pad"], row))
    v = sheet.place(section(cut), 330, 620, 15)
    right, z = d.board_length / 2, d.board_front
    dabs = [("glue", _drop(s * (right - 0.6), z, 1.2, d.dimple_height + 0.2)) for s in (-1, 1)]
    tie = -d.outer[0] / 2 - d.tongue_length / 2
    wires = _box(-13.4, d.floor + 0.9, 9.0, 1.6)
    band = _box(tie, d.floor + 2.0, 2.5, 0.6)
    sheet.place(_areas(*dabs, ("copper", wires), ("paper", band)), 330, 620, 15)
    _down(v, 0, d.pad_top + lift + 2.4, d.pad_top + lift + 0.2)
    v.labels(
        560, 400,
        [
            ((right - 0.8, d.pad_top + lift - 0.9), "pad, dimples down"),
            ((right - 0.5, z + 0.5), "dab of silicone"),
            ((d.inner[0] / 2 - 0.1, z + 1.0), "gap: stays free"),
        ],
        44,
    )  # fmt: skip
    v.label((tie, d.floor + 2.3), "cable tie", 10, -92)
    return sheet


#: Drawing of each step of gluing, in order.
STEPS: dict[str, Callable[[Dimensions], Drawing]] = {
    "gluing-1-foils": foils,
    "gluing-2-silicone": silicone,
    "gluing-3-disc": disc,
    "gluing-4-fitting": fitting,
    "gluing-5-board": board,
    "gluing-6-velostat": sheet_of_velostat,
    "gluing-7-pad": pad,
}
