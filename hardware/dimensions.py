"""Table of the dimensions of the fingertip's mount, pad, mould and jig, mm.

The solids, the drawings, the checks and the table of the build page are made from
:class:`Dimensions`. Each value names its source, or is marked as an assumption. Heights of the
assembled fingertip begin at the back of the mount.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields

from circuit import ASSUMED, COLUMNS, PAPER, ROWS


def _mm(value: float, meaning: str, source: str = ASSUMED) -> float:
    return field(default=value, metadata={"meaning": meaning, "source": source})


@dataclass(frozen=True)
class Dimensions:
    """Dimensions in mm, angles in degrees. The x axis points from the hand to the tip."""

    # The fingertip
    board_length: float = _mm(20.0, "board, along the finger", PAPER)
    board_width: float = _mm(15.0, "board, across the finger", PAPER)
    board_thickness: float = _mm(1.6, "FR4, the usual thickness")
    board_tolerance: float = _mm(0.16, "10 % of the thickness, as board houses state")
    disc_diameter: float = _mm(10.0, "PZT disc", PAPER)
    disc_thickness: float = _mm(0.2, "PZT disc, a size that is sold")
    sheet_thickness: float = _mm(0.1, "Velostat", PAPER)
    sheet_length: float = _mm(19.0, "Velostat: covers the combs, and stays off the board's edges")
    sheet_width: float = _mm(14.0, "the same")
    sheet_cut: float = _mm(0.5, "cut of the Velostat's corners: they would catch, and bare no comb")
    tape_length: float = _mm(10.0, "tape that holds a long side of the Velostat")
    tape_width: float = _mm(1.0, "the same: half of it on the sheet")
    pad_thickness: float = _mm(3.0, "silicone without its dimples", PAPER)
    dimple_diameter: float = _mm(2.0, "end of a dimple: six are as stiff as a tenth of the pad")
    dimple_height: float = _mm(0.8, "dimple, flat before the pad is")
    board_glue: float = _mm(0.15, "silicone between disc and board: room for the foil")
    post_glue: float = _mm(0.1, "silicone between disc and post: one sheet of paper")

    foils: float = _mm(3, "number of folded foils that connect disc and land")
    foil_side: float = _mm(1.5, "side of a folded foil")
    foil_place: float = _mm(3.0, "foil, from the middle of the disc")

    # Printing
    nozzle: float = _mm(0.4, "nozzle")
    layer: float = _mm(0.2, "layer height: heights of printed faces are multiples of it")
    thinnest: float = _mm(1.2, "least wall: three lines of the nozzle")
    bridge: float = _mm(8.0, "longest bridge without support")
    edge: float = _mm(0.4, "chamfer of outer edges, also against a wide first layer")

    # Mount
    clearance: float = _mm(0.2, "between the board's edges and the walls")
    wall: float = _mm(1.6, "walls: four lines of the nozzle")
    floor: float = _mm(4.8, "floor of the tray: holds the threads")
    post_height: float = _mm(3.0, "post above the floor: room for wires under the board")
    wall_top: float = _mm(11.6, "walls above the back: hold the pad's lower third")
    joint_length: float = _mm(2.0, "step in the post's edge for the solder joint of the disc")
    joint_depth: float = _mm(1.2, "the same, below the post's top")
    cable_width: float = _mm(
        12.6, "opening for nine wires of up to 1 mm, 1.45 mm apart on the board"
    )
    tongue_length: float = _mm(8.0, "tongue that the cable is tied to")
    tongue_width: float = _mm(13.2, "the same")
    tie_width: float = _mm(3.2, "slots for a cable tie of 2.5 mm")
    tie_thickness: float = _mm(1.6, "the same")
    tie_spacing: float = _mm(8.8, "between the middles of the slots")
    screw_length: float = _mm(16.0, "between screws along the finger")
    screw_width: float = _mm(11.0, "between screws across the finger")
    screw_diameter: float = _mm(2.0, "M2")
    insert_diameter: float = _mm(3.2, "hole for a heat-set insert M2, 3 mm long and 3.5 mm wide")
    insert_depth: float = _mm(3.4, "the same")

    # Mould of the pad
    draft: float = _mm(2.0, "draft of the pad's sides and dimples, degrees")
    land: float = _mm(1.6, "rim around each pad, on which the glass lies")
    gutter: float = _mm(2.0, "width of the gutter around the rims")
    gutter_depth: float = _mm(1.6, "depth of the gutter below the rims")
    border_drop: float = _mm(0.8, "outer border below the rims")
    mould_floor: float = _mm(1.6, "below the dimples")

    # Jig: the locator centres the disc on the board, the press sets the board's height
    board_fit: float = _mm(0.15, "between board and locator, each side")
    disc_fit: float = _mm(0.15, "between disc and locator, radial")
    locator_depth: float = _mm(1.0, "skirt of the locator over the board's edges")
    plate: float = _mm(1.6, "plate of the locator")
    slot: float = _mm(3.0, "slot of the locator for the disc's wire")
    squeeze: float = _mm(0.4, "chamfer of the locator's hole: keeps it off the glue")
    press_plate: float = _mm(3.0, "plate of the press")
    press_margin: float = _mm(1.0, "from the press's face to the board's edges")
    press_drop: float = _mm(2.6, "face of the press below its plate")
    paper: float = _mm(0.1, "copy paper of 80 g/m²")

    # Adapter to a finger
    finger_fit: float = _mm(0.2, "between finger and cheeks, each side: thin tape fills it")
    cheek: float = _mm(2.4, "cheeks beside the finger")
    cheek_share: float = _mm(0.6, "height of the cheeks, as a share of the finger's thickness")
    stop: float = _mm(2.0, "wall at the finger's tip")
    ledge: float = _mm(2.0, "below the heads of the screws: M2 × 5 reach 3 mm into the mount")
    head_diameter: float = _mm(4.4, "room for a head of a screw M2, 3.8 mm wide")
    head_depth: float = _mm(2.2, "the same: heads are 2 mm high")
    screw_hole: float = _mm(2.4, "hole for a screw M2")
    tie_place: float = _mm(2.9, "cable ties, from the middle of the mount along the finger")

    @property
    def inner(self) -> tuple[float, float]:
        """Length and width of the tray inside its walls, mm."""
        return self.board_length + 2 * self.clearance, self.board_width + 2 * self.clearance

    @property
    def outer(self) -> tuple[float, float]:
        """Length and width of the tray with its walls, mm."""
        return self.inner[0] + 2 * self.wall, self.inner[1] + 2 * self.wall

    @property
    def post_top(self) -> float:
        """Height of the post's top above the mount's back, mm."""
        return self.floor + self.post_height

    @property
    def board_back(self) -> float:
        """Height of the board's back above the mount's back, mm."""
        return self.post_top + self.post_glue + self.disc_thickness + self.board_glue

    @property
    def board_front(self) -> float:
        """Height of the board's front above the mount's back, mm."""
        return self.board_back + self.board_thickness

    @property
    def pad_bottom(self) -> float:
        """Height of the pad's underside, without its dimples, above the mount's back, mm."""
        return self.board_front + self.sheet_thickness + self.dimple_height

    @property
    def pad_top(self) -> float:
        """Height of the pad's face above the mount's back, mm."""
        return self.pad_bottom + self.pad_thickness

    @property
    def mould_top(self) -> float:
        """Height of the rims of the mould, mm."""
        return self.mould_floor + self.dimple_height + self.pad_thickness

    @property
    def mould_pitch(self) -> float:
        """Distance between the middles of the mould's two cavities, mm."""
        return self.board_length + 2 * self.land + self.gutter

    @property
    def press_gap(self) -> float:
        """Gap between press and walls before gluing, mm, for a board of the nominal thickness."""
        return self.press_drop - (self.wall_top - self.board_front) - self.post_glue

    @property
    def taxels(self) -> list[tuple[float, float]]:
        """Middles (x, y) of the taxels, mm. A dimple of the pad lies on each."""
        length, width = self.board_length / ROWS, self.board_width / COLUMNS
        return [
            ((row - (ROWS - 1) / 2) * length, ((COLUMNS - 1) / 2 - column) * width)
            for row in range(ROWS)
            for column in range(COLUMNS)
        ]

    @property
    def screws(self) -> list[tuple[float, float]]:
        """Middles (x, y) of the threads in the mount's back, mm."""
        return [
            (x * self.screw_length / 2, y * self.screw_width / 2) for x in (-1, 1) for y in (-1, 1)
        ]

    def pad_volume(self) -> float:
        """Return the volume of one pad, mm³: a truncated pyramid and truncated cones."""
        slope, h = math.tan(math.radians(self.draft)), self.pad_thickness
        faces = [
            (self.board_length - 2 * z * slope) * (self.board_width - 2 * z * slope)
            for z in (0, h / 2, h)
        ]
        end = self.dimple_diameter / 2
        root = end + self.dimple_height * slope
        dimple = math.pi / 3 * self.dimple_height * (end**2 + end * root + root**2)
        return h / 6 * (faces[0] + 4 * faces[1] + faces[2]) + len(self.taxels) * dimple


NOMINAL = Dimensions()


def sources(dimensions: Dimensions = NOMINAL) -> list[tuple[str, float, str, str]]:
    """Return (name, value, meaning, source) of each dimension."""
    return [
        (f.name, getattr(dimensions, f.name), f.metadata["meaning"], f.metadata["source"])
        for f in fields(dimensions)
    ]
