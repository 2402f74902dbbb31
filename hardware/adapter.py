"""Make an adapter from the fingertip's mount to a robot's finger. Needs build123d.

python hardware/adapter.py --width 16 --thickness 14 --length 30

Writes adapter.stl and adapter.step to hardware/out, once all checks have passed. The lengths of
the finger are measured with a caliper, as ``docs/how-to/build-a-fingertip.md`` shows. The finger
lies in a saddle: a plate with the mount's four holes, cheeks beside the finger, a wall at its tip.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass

import mesh
from build123d import Align, Box, Cylinder, Part, Pos, export_step
from dimensions import NOMINAL, Dimensions
from drawing import ISOMETRIC, Drawing, View, pictured, section

_UP = (Align.CENTER, Align.CENTER, Align.MIN)


@dataclass(frozen=True)
class Finger:
    """Lengths of a finger's last segment, mm. The defaults are the example of the drawing."""

    width: float = 16.0
    """Across the finger."""
    thickness: float = 14.0
    """From the side that grips to the back."""
    length: float = 30.0
    """From the tip back, as far as the finger stays equally wide and thick."""


def check_finger(f: Finger, d: Dimensions) -> None:
    """Raise ValueError if an adapter cannot be made for these lengths of a finger."""
    shortest = d.screw_length + d.head_diameter + 2 * d.thinnest
    if f.length < shortest:
        raise ValueError(f"--length must be at least {shortest:.1f} mm: the screws need it")
    for name, value, least in (("width", f.width, d.screw_width), ("thickness", f.thickness, 8.0)):
        if not least <= value <= 40:
            raise ValueError(f"--{name} must be {least:g} to 40 mm")


def plate_thickness(d: Dimensions) -> float:
    """Return the thickness of the plate between mount and finger, mm."""
    return d.ledge + d.head_depth


def outer_width(f: Finger, d: Dimensions) -> float:
    """Return the width over the adapter's cheeks, mm.

    Screw heads need at least the mount's width.
    """
    return max(f.width + 2 * (d.finger_fit + d.cheek), d.outer[1])


def adapter(f: Finger, d: Dimensions) -> Part:
    """Return the adapter in its position for printing: the mount's side on z = 0, the tip at +x."""
    check_finger(f, d)
    floor, cheek = plate_thickness(d), d.cheek_share * f.thickness
    outer, tip = outer_width(f, d), d.outer[0] / 2
    length = max(f.length, d.outer[0])
    size = length + d.stop, outer, floor + cheek
    solid = Pos(tip + d.stop - size[0] / 2, 0, 0) * Box(*size, align=_UP)
    room = Box(length + 1, f.width + 2 * d.finger_fit, cheek + 1, align=_UP)
    solid -= Pos(tip - (length + 1) / 2, 0, floor) * room
    for x, y in d.screws:
        solid -= Pos(x, y, -1) * Cylinder(d.screw_hole / 2, floor + 1, align=_UP)
        solid -= Pos(x, y, d.ledge) * Cylinder(d.head_diameter / 2, floor + cheek, align=_UP)
    for x in (-d.tie_place, d.tie_place):
        tunnel = Box(d.tie_width, outer + 2, d.tie_thickness, align=_UP)
        solid -= Pos(x, 0, (floor - d.tie_thickness) / 2) * tunnel
    return solid


def drawing(d: Dimensions, f: Finger | None = None) -> Drawing:
    """Return the drawing of the lengths to measure on a finger, and of the adapter."""
    f = f or Finger()
    sheet = Drawing(980, 410, "Finger with the three lengths to measure, and its adapter")
    a, corner = f.width / 2, 3.0
    end = [
        (corner - a, 0), (a - corner, 0), (a, corner), (a, f.thickness - corner),
        (a - corner, f.thickness), (corner - a, f.thickness), (-a, f.thickness - corner),
        (-a, corner),
    ]  # fmt: skip
    sheet.text(40, 28, "Finger, towards its tip", "t")
    v = sheet.place(View(areas=[("silicone", [end])], is_section=True), 140, 240, 10)
    v.width(-a, a, f.thickness / 2, f.thickness + 2, "width")
    v.height(0, f.thickness, a, a + 3, "thickness")
    sheet.text(40, 290, "below: the side that grips", "s")
    sheet.text(280, 28, "Finger, from the side", "t")
    side = [(-f.length, 0), (0, 0), (0, f.thickness), (-f.length, f.thickness),
            (-f.length - 3, f.thickness + 2), (-f.length - 3, -1)]  # fmt: skip
    v = sheet.place(View(areas=[("silicone", [side])], is_section=True), 590, 240, 8)
    v.width(-f.length, 0, 0, -3, "length, equally wide and thick")
    v.label((-2, f.thickness / 2), "tip", 24, -20)
    sheet.text(660, 28, "Adapter", "t")
    part = adapter(f, d)
    sheet.place(pictured(part, "petg", ISOMETRIC), 830, 150, 6.5)
    v = sheet.place(section([("petg", part, d.screws[1][1])]), 830, 330, 7)
    v.label((d.screws[-1][0], d.ledge + 0.5), "M2 × 5", 30, 34)
    v.label((-d.tie_place, d.ledge), "cable ties", -70, 34)
    sheet.text(740, 392, "below: the mount", "s")
    return sheet


def main(d: Dimensions = NOMINAL) -> int:
    """Make, check and write an adapter."""
    from mount import OUT, TIMESTAMP, check_print, triangles  # mount.py draws the adapter

    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("width", "thickness", "length"):
        parser.add_argument(f"--{name}", type=float, required=True, help="mm")
    try:
        part = adapter(Finger(**vars(parser.parse_args())), d)
        surface = triangles(part)
        check_print("adapter", surface, d)
    except ValueError as error:
        print(error, file=sys.stderr)
        return 1
    OUT.mkdir(exist_ok=True)
    mesh.write_stl(OUT / "adapter.stl", surface)
    export_step(part, OUT / "adapter.step", timestamp=TIMESTAMP)
    x, y, z = mesh.size(surface)
    print(f"{OUT / 'adapter.stl'}: {x:.1f} × {y:.1f} × {z:.1f} mm")
    return 0


if __name__ == "__main__":
    sys.exit(main())
