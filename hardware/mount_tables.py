"""Markdown tables of the build page on printing, pouring and gluing."""

from __future__ import annotations

from pathlib import Path

import mesh
from dimensions import NOMINAL as D

from firstcontact_lab.report.tables import markdown_table

PARTS = Path(__file__).resolve().parent / "mount"
#: Density of PETG, g/mm³: 1.27 g/cm³ in data sheets.
PETG = 1.27e-3


def print_table() -> str:
    """Return a table of the parts to print, with their settings and screws."""
    length, width = D.inner
    board, disc = 2 * D.board_fit, 2 * D.disc_fit
    measures = {
        "mount": f"tray {length:.1f} × {width:.1f}; walls {D.wall_top - D.post_top:.1f} above post",
        "mould": f"cavities {D.board_length:.1f} × {D.board_width:.1f}, {D.pad_thickness:.1f} deep",
        "locator": (
            f"pocket {D.board_length + board:.1f} × {D.board_width + board:.1f}; "
            f"hole {D.disc_diameter + disc:.1f}"
        ),
        "press": f"face {D.press_drop:.1f} above the plate",
    }
    rows = []
    for name, measure in measures.items():
        surface = mesh.read_stl(PARTS / f"{name}.stl")
        size = " × ".join(f"{side:.1f}" for side in mesh.size(surface))
        weight = f"{mesh.volume(surface) * PETG:.1f} g"
        rows.append((f"`{name}.stl`", "2" if name == "mount" else "1", size, weight, measure))
    lines = round(D.wall / D.nozzle)
    settings = [
        ("material", "PETG"),
        ("nozzle, layer height", f"{D.nozzle:g} mm, {D.layer:g} mm"),
        ("walls, infill", f"{lines} lines, 100 %: the post carries the grip"),
        ("orientation", "as in the files, without supports or brim"),
        ("upper faces", "ironing on, for the post and the floor of the mould"),
        ("longest bridge", f"{D.insert_diameter:g} mm, above the holes for the inserts"),
        (
            "four inserts in each mount",
            f"M2, 3 mm long, 3.5 mm wide, into holes of {D.insert_diameter:g} mm",
        ),
        (
            "holes in your finger",
            f"four of 2.4 mm, {D.screw_length:g} mm apart along the finger and "
            f"{D.screw_width:g} mm across",
        ),
        ("screws", "M2, 3 mm longer than your finger's plate is thick"),
    ]
    parts = markdown_table(
        "part | copies | size, mm | solid weight | measure, mm, each ± 0.1", rows
    )
    return parts + "\n" + markdown_table("what | value", settings)


def pour_table() -> str:
    """Return a table to check a poured pad: volume, thickness, dimples, face and hardness."""
    over = D.pad_thickness + D.dimple_height
    return markdown_table(
        "check | should be | otherwise",
        [
            (
                "volume of two pads",
                f"{2e-3 * D.pad_volume():.1f} ml; mix 10 g at least, since less is hard to weigh",
                "–",
            ),
            (
                "thickness over the dimples, caliper just touching", f"{over:g} ± 0.1 mm",
                "thicker: the slide did not lie on the rims",
            ),
            (
                "dimples, against the light", "six, full and without bubbles",
                "brush silicone into the recesses first",
            ),
            ("face", "smooth, not sticky", "sticky: the mould or a glove stopped the cure"),
            (
                "hardness of the cup after a day, 12 mm from its edge",
                "65 ± 5 Shore A: write it down", "softer: weigh the two parts more exactly",
            ),
        ],
    )  # fmt: skip


def fit_table() -> str:
    """Return a table of the lengths to check on a glued fingertip."""
    added = D.disc_thickness + D.board_glue
    least, most = (round((D.press_gap + sign * D.board_tolerance) / D.paper) for sign in (-1, 1))
    return markdown_table(
        "check | should be",
        [
            ("board with its disc, thicker than the board alone by", f"{added:g} ± 0.05 mm"),
            (
                "paper below each corner of the press, before gluing",
                f"{least} to {most} sheets, since boards differ",
            ),
            (
                "front of the board below the top of the walls",
                f"{D.wall_top - D.board_front:.2f} ± 0.2 mm; equal within 0.1 mm at the corners",
            ),
            (
                "gap around the board",
                f"{D.clearance:g} mm: one sheet of paper ({D.paper:g} mm) passes everywhere",
            ),
            (
                "face of the pad above the top of the walls",
                f"{D.pad_top - D.wall_top:.2f} ± 0.3 mm",
            ),
        ],
    )  # fmt: skip
