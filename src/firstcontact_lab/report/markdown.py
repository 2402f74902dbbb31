"""Tables of the report for pages in Markdown."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from firstcontact_lab.report import _anytime_tables as anytime_tables
from firstcontact_lab.report._tables import Table
from firstcontact_lab.report.results.study import SubjectResults

#: What makes the tables of a page, by what they are called there.
TABLES: Mapping[str, tuple[Callable[[SubjectResults], Table | None], ...]] = {
    "anytime": (anytime_tables.anytime_table,),
    "off_blocks": (anytime_tables.objects_off_blocks, anytime_tables.others_off_blocks),
}


def markdown(name: str, conditions: Mapping[str, SubjectResults]) -> str:
    """Tables of that name with their captions, of each condition that has them; or ""."""
    parts = []
    for make in TABLES[name]:
        for condition, results in conditions.items():
            table = make(results)
            if table is not None:
                title = condition.capitalize().replace("-", " ")
                parts.append(f"**{title}.** {table.caption}\n\n{_rows(table)}")
    return "\n".join(parts)


def _rows(table: Table) -> str:
    lines = [list(table.head), ["---"] * len(table.head)]
    for row in table.rows:
        lines.append([f"{c.text} ({c.small})" if c.small else c.text for c in row.cells])
    return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)
