"""Board of the fingertip: six taxels on its front, disc and wires on its back.

The board lies with its cable to the left. From left to right there are row 2, row 1 and row 0; row
0 is at the tip. Column 0 is the lower one.

A finger of a comb is 0.3 mm wide and so is the gap. Both are well above what board houses etch
without extra cost (0.15 mm), so that gold does not bridge a gap. A dimple of 2 mm covers three
periods: wherever it lands along the comb, the length of gap below it varies by less than 4 %.
"""

from __future__ import annotations

import math

from circuit import CABLE, COLUMNS, ROWS
from dimensions import NOMINAL
from layout import BACK, REVISION, TRACK, Layout, Point, Step, Text, Track

#: Size of the board and its thickness, mm.
LENGTH, WIDTH = NOMINAL.board_length, NOMINAL.board_width
THICKNESS = NOMINAL.board_thickness
#: Width of a comb's finger and of the gap beside it, mm.
FINGER, GAP = 0.3, 0.3
#: Fingers of a taxel. The outer ones belong to the row: an idle row is held at ground and so
#: separates the columns' fingers of neighbouring rows.
FINGERS = 9
#: Half of the length over which the fingers overlap, mm.
OVERLAP = 2.25
#: Widths of the spines of row and column, and from the end of the overlap to each of them.
ROW_SPINE, COLUMN_SPINE = 0.3, 0.4
#: Opening of the solder mask beyond the fingers, mm. The spines stay covered.
OPENING = 0.12
#: Radius of the disc's land on the back, mm.
LAND = NOMINAL.disc_diameter / 2
#: Pads of the nine wires, mm: place, pitch and size.
WIRES_X, WIRES_PITCH, WIRE_PAD = -8.45, 1.45, (1.4, 0.95)
#: Pad of the thin wire to the disc's outer face, relative to the disc, and its side.
DISC_WIRE, DISC_WIRE_SIDE = (-6.1, -2.3), 1.2


def taxel_center(row: int, column: int) -> Point:
    """Return the middle of a taxel on the board, mm."""
    pitch_x, pitch_y = LENGTH / ROWS, WIDTH / COLUMNS
    return (ROWS - 1) / 2 * pitch_x - row * pitch_x, ((COLUMNS - 1) / 2 - column) * pitch_y


def comb(kind: str) -> list[Point]:
    """Return the outline of a comb of column 0, relative to the taxel.

    The comb of a ``row`` has its spine towards the middle of the board, that of a ``column``
    towards the edge. Column 1 has the same taxel, turned by 180 degrees.
    """
    period, half = FINGER + GAP, (FINGERS * (FINGER + GAP) - GAP) / 2
    is_row = kind == "row"
    near = -OVERLAP - GAP if is_row else OVERLAP + GAP  # edge of the spine at the fingers
    far = near - ROW_SPINE if is_row else near + COLUMN_SPINE
    tip = -near - math.copysign(GAP, -near)
    outline: list[Point] = [(half, near), (half, far), (-half, far), (-half, near)]
    for number in range(0 if is_row else 1, FINGERS, 2):
        left = -half + number * period
        outline += [(left, near), (left, tip), (left + FINGER, tip), (left + FINGER, near)]
    return [*dict.fromkeys((round(x, 4), round(y, 4)) for x, y in outline)]


def gap_length(x: float, diameter: float = NOMINAL.dimple_diameter, steps: int = 2000) -> float:
    """Return the length of the comb's gaps under a dimple whose middle is at ``x``, mm.

    The comb is larger than the dimple.
    """
    radius, period = diameter / 2, FINGER + GAP
    total = 0.0
    for step in range(steps):
        at = -radius + diameter * (step + 0.5) / steps
        if (at + x) % period < GAP:
            total += 2 * math.sqrt(radius**2 - at**2) * diameter / steps
    return total / GAP


def _spines() -> list[Track]:
    """Return the tracks on the front: spines of the columns, and links from rows to their vias."""
    y_row = WIDTH / 4 - OVERLAP - GAP - ROW_SPINE / 2
    y_column = WIDTH / 4 + OVERLAP + GAP + COLUMN_SPINE / 2
    xs = [taxel_center(row, 0)[0] for row in range(ROWS)]
    way = 0.6  # of row 1 from the middle: as far from the spines of row 2 as from the via of row 0
    return [
        # Columns, straight through the three taxels. Column 1 ends at the cable. Column 0 returns
        # to it round the tip: no track lies below the wires, which leave over the board's edge.
        Track(((xs[0], -y_column), (-9.45, -y_column), Step.VIA, "J1.1"), width=0.4),
        Track(((xs[-1], y_column), (9.45, y_column)), width=0.4, net="column_0"),
        Track(((9.45, y_column), Step.VIA, (9.45, -7.05), (-6.4, -7.05), (-7.1, -4.35), "J1.2")),
        # Row 0 runs between the halves of row 1, and both run between those of row 2.
        Track(((xs[0], -y_row), (xs[0], y_row)), width=0.3, net="row_0"),
        Track(((xs[0], 0), (-5.5, 0), Step.VIA, (-5.5, 3.2), (-6.65, 4.35), "J1.8")),
        *(
            Track(
                (
                    (-2.0, side * y_row), (-3.0, side * y_row), (-3.45, side * way),
                    (-6.3, side * way), (-6.3, 0),
                ), width=TRACK, net="row_1",
            )
            for side in (-1, 1)
        ),
        Track(((-6.3, 0), Step.VIA, (-6.3, 1.85), (-7.35, 2.9), "J1.7")),
        Track(((-7.12, -y_row), (-7.12, y_row)), net="row_2"),
        Track(((-7.12, 0), Step.VIA, (-7.12, 0.95), (-7.62, 1.45), "J1.6")),
        # Disc, strip and ground, on the back.
        Track(("J1.4", "BZ1.1"), BACK, 0.3),
        Track(("J1.9", "E1.1"), BACK, 0.3),
        Track(("J1.5", (-8.15, 0), (-7.35, -0.8), (-4.5, -0.8)), BACK, 0.3),
    ]  # fmt: skip


FINGERTIP = Layout(
    name="fingertip",
    title="firstcontact fingertip",
    corner=(-LENGTH / 2, -WIDTH / 2),
    size=(LENGTH, WIDTH),
    places={
        "J1": (WIRES_X, 0, 0),
        "E1": (-5.6, 5.9, 0),
        "BZ1": (0, 0, 0),
        **{
            f"T{COLUMNS * row + column}": (*taxel_center(row, column), 180 * column)
            for row in range(ROWS)
            for column in range(COLUMNS)
        },
    },
    tracks=tuple(_spines()),
    grounded=(BACK,),
    texts=(
        Text("firstcontact", (0.5, -6.2), 0.9, side=BACK),
        Text(f"fingertip, rev {REVISION}", (0.2, 6.3), 0.8, side=BACK),
        Text("1", (-7.1, -5.8), 0.8, side=BACK),
        Text("strip", (-5.6, 4.75), 0.8, side=BACK),
        *(
            Text(
                f"{n + 1} {wire.replace('column', 'col').replace('_', '')}",
                (9.6, (n - 4) * WIRES_PITCH),
                0.8,
                side=BACK,
                align=-1,
            )
            for n, wire in enumerate(CABLE)
        ),
    ),
)
