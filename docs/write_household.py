"""Write the tables of docs/reference/twin-parameters.md from the household's data files.

The tables lie between ``<!-- household: NAME -->`` and ``<!-- /household -->``. A test compares
them with the data.
"""

from __future__ import annotations

from pathlib import Path

from firstcontact.core.display import FAMILIAR
from firstcontact.twin.household import HOUSEHOLD, Quantity, read_table
from firstcontact_lab.report.tables import fill, markdown_table

PAGE = Path(__file__).parent / "reference/twin-parameters.md"
#: Sources of the numbers.
SOURCES = read_table("household_sources.csv")
#: How each quantity is shown: heading, factor, digits.
SHOWN = {
    "shore_a": ("Shore A", 1.0),
    "mass": ("mass, g", 1e3),
    "friction": ("friction", 1.0),
    "limit": ("damage limit, N", 1.0),
    "weibull": ("Weibull modulus", 1.0),
    "radius": ("radius, mm", 1e3),
    "thickness": ("thickness, mm", 1e3),
    "bulk": ("stiffness, N/mm", 1e-3),
    "loss": ("loss factor", 1.0),
}


def _cell(quantity: Quantity | None, factor: float, marks: dict[str, int]) -> str:
    if quantity is None:
        return "–"
    figure = f"{factor * quantity.value:.4g}"
    return figure if quantity.estimated else f"**{figure}** [{marks[quantity.source]}]"


def tables() -> dict[str, str]:
    """Return the tables of objects, and the numbered list of sources."""
    marks = {source["key"]: i + 1 for i, source in enumerate(SOURCES)}
    heads = ["object", "class", "origin", *(title for title, _ in SHOWN.values())]
    rows = []
    for kind in HOUSEHOLD:
        cells = [_cell(getattr(kind.numbers, name), f, marks) for name, (_, f) in SHOWN.items()]
        rows.append((kind.name, kind.group, kind.origin, *cells))
    sources = [
        "{}. {authors} ({year}). *{title}*. {where}.".format(number, **source)
        for number, source in enumerate(SOURCES, start=1)
    ]
    familiar = [(name, f"{shore_a:g}", source) for name, shore_a, source in FAMILIAR]
    return {
        "objects": markdown_table(" | ".join(heads), rows),
        "sources": "\n".join(sources),
        "familiar": markdown_table("object | Shore A | source", familiar),
    }


def filled(text: str) -> str:
    """Return the page with its tables in place."""
    return fill(text, "household", tables())


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
