"""Markdown tables for orders: settings of the board house, and accessories of the boards."""

from __future__ import annotations

from amplifier_layout import AMPLIFIER
from boards import FOLDER
from circuit import ACCESSORIES
from fingertip_layout import FINGERTIP, THICKNESS
from layout import CLEARANCE, DRILL, VIA, Layout
from sexpr import all_of, numbers, one_of, parse

from firstcontact_lab.report.tables import markdown_table


def _narrowest(layout: Layout) -> float:
    """Return the smallest width of a track on the committed board, mm."""
    board = parse((FOLDER / layout.name / f"{layout.name}.kicad_pcb").read_text("utf-8"))
    return min(numbers(one_of(segment, "width"))[0] for segment in all_of(board, "segment"))


def order_table() -> str:
    """Return a table of the settings on the board house's order form."""
    both = (AMPLIFIER, FINGERTIP)
    rows = [
        ("file", *(f"`hardware/fab/{layout.name}-gerbers.zip`" for layout in both)),
        ("how many you need", "1", "2"),
        ("size", *(f"{layout.size[0]:g} × {layout.size[1]:g} mm" for layout in both)),
        ("edges", "routed, no panel", "routed, no panel, ± 0.1 mm if offered"),
        ("layers, base material", "2, FR4", "2, FR4"),
        ("thickness", f"{THICKNESS:g} mm", f"{THICKNESS:g} mm"),
        ("copper", "35 µm (1 oz)", "35 µm (1 oz)"),
        ("surface finish", "ENIG or lead-free HASL", "**ENIG**: tin is uneven and oxidises"),
        ("narrowest track", *(f"{_narrowest(layout):g} mm" for layout in both)),
        ("narrowest gap", *(f"{CLEARANCE:g} mm" for _ in both)),
        ("smallest hole, its ring", *(f"{DRILL:g} mm, {VIA:g} mm across" for _ in both)),
        ("vias", "covered with solder mask (tented)", "covered with solder mask (tented)"),
        ("solder mask, print", "green, white", "green, white"),
        ("order number of the house", "anywhere", "none"),
        ("electrical test", "yes", "yes"),
        ("stencil", "optional, front only", "none: no solder paste"),
        ("impedance, gold fingers, castellated holes", "no", "no"),
    ]
    return markdown_table("setting | amplifier | fingertip", rows)


def accessories_table() -> str:
    """Return a table of what belongs to the boards without being soldered to them."""
    rows = ((name, str(count), what) for name, count, what in ACCESSORIES)
    return markdown_table("what | how many | what for", rows)
