"""Write the tables of docs/reference/household.md from the household's data files.

The tables lie between ``<!-- household: NAME -->`` and ``<!-- /household -->``. A test compares
them with the data.
"""

from __future__ import annotations

import re
from pathlib import Path

from firstcontact.twin.household import HOUSEHOLD, HOUSEHOLD_SOURCES, Quantity

PAGE = Path(__file__).parent / "reference/household.md"
TABLE = re.compile(
    r"(?P<open><!-- household: (?P<name>\w+) -->\n).*?(?P<close><!-- /household -->)", re.DOTALL
)
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
    """Return the table of objects, and the numbered list of sources."""
    marks = {key: i + 1 for i, key in enumerate(HOUSEHOLD_SOURCES)}
    heads = ["object", "group", "origin", *(title for title, _ in SHOWN.values())]
    lines = ["| " + " | ".join(heads) + " |", "| " + " | ".join(["---"] * len(heads)) + " |"]
    for specimen in HOUSEHOLD:
        cells = [_cell(getattr(specimen.numbers, n), f, marks) for n, (_, f) in SHOWN.items()]
        lines.append(
            "| " + " | ".join([specimen.name, specimen.group, specimen.origin, *cells]) + " |"
        )
    sources = [
        f"{marks[s.key]}. {s.authors} ({s.year}). *{s.title}*. {s.where}."
        for s in HOUSEHOLD_SOURCES.values()
    ]
    return {"objects": "\n".join(lines) + "\n", "sources": "\n".join(sources) + "\n"}


def filled(text: str) -> str:
    """Return the page with its tables in place."""
    made = tables()
    return TABLE.sub(lambda m: f"{m['open']}\n{made[m['name']]}\n{m['close']}", text)


def main() -> None:
    """Write the tables."""
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
