"""Names and settings that a KiCad board shares with its schematic."""

from __future__ import annotations

import json
import uuid
from pathlib import Path
from typing import Any

from layout import CLEARANCE, DRILL, TRACK, VIA

#: Nets with a power symbol. They have no sheet in their name.
POWER_NETS = ("3v3", "gnd")
SPACE = uuid.UUID("5f3c1d0e-36b0-4f0a-9b5e-0f1c0a7e0036")


def net_name(net: str) -> str:
    """Return the name that KiCad gives to a net of the table of parts."""
    return net if net in POWER_NETS else f"/{net}"


def path_id(board: str, *names: str) -> str:
    """Return the identifier of a symbol, which is equal in each run, on board and schematic."""
    return str(uuid.uuid5(SPACE, "/".join((board, *names))))


def write_project(file: Path) -> None:
    """Write a KiCad project file: rules of the board house, and checks to leave out."""
    no_library = "ignore"  # symbols and footprints are in the files themselves
    rules = {
        "min_clearance": CLEARANCE, "min_track_width": TRACK, "min_via_diameter": VIA,
        "min_via_annular_width": (VIA - DRILL) / 2, "min_through_hole_diameter": DRILL,
        "min_copper_edge_clearance": 0.25, "min_hole_clearance": 0.25, "min_hole_to_hole": 0.25,
        "min_silk_clearance": 0.0, "min_text_height": 0.8, "min_text_thickness": 0.1,
        "solder_mask_to_copper_clearance": 0.0,
    }  # fmt: skip
    net_class = {
        "name": "Default", "clearance": CLEARANCE, "track_width": 0.25, "via_diameter": VIA,
        "via_drill": DRILL, "priority": 2147483647, "microvia_diameter": 0.3,
        "microvia_drill": 0.1, "diff_pair_gap": 0.25, "diff_pair_width": 0.2,
        "diff_pair_via_gap": 0.25, "bus_width": 12, "line_style": 0, "wire_width": 6,
        "pcb_color": "rgba(0, 0, 0, 0.000)", "schematic_color": "rgba(0, 0, 0, 0.000)",
    }  # fmt: skip
    board: dict[str, Any] = {
        "design_settings": {
            "rules": rules,
            "rule_severities": {
                "lib_footprint_issues": no_library, "lib_footprint_mismatch": no_library,
            },
        }
    }  # fmt: skip
    project = {
        "board": board,
        "erc": {
            "rule_severities": {
                "lib_symbol_issues": no_library, "lib_symbol_mismatch": no_library,
                "footprint_link_issues": no_library,
            }
        },
        "meta": {"filename": file.name, "version": 3},
        "net_settings": {"classes": [net_class], "meta": {"version": 4}},
    }  # fmt: skip
    file.write_text(json.dumps(project, indent=2) + "\n", "utf-8")


def write_projects(folder: Path) -> None:
    """Write the KiCad project files of both boards."""
    for name in ("amplifier", "fingertip"):
        (folder / name).mkdir(parents=True, exist_ok=True)
        write_project(folder / name / f"{name}.kicad_pro")
