"""Page of a report: one HTML file that needs no other file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

from firstcontact.core import sanitize
from firstcontact_lab.report.findings import Figure
from firstcontact_lab.report.tables import Table

if TYPE_CHECKING:
    from jinja2 import Template

#: Largest number of columns of a table that is shown next to another table.
_HALF = 8


@dataclass(frozen=True, slots=True)
class Column:
    """Tables and figures of one subject in a section."""

    title: str
    tables: Sequence[Table]
    figures: Sequence[Figure]


@dataclass(frozen=True, slots=True)
class Section:
    """Section of a report."""

    anchor: str
    title: str
    text: str
    columns: Sequence[Column] = ()
    sentences: Sequence[str] = ()
    figures: Sequence[Figure] = ()
    table: Table | None = None
    details: Sequence[Column] = ()

    @property
    def wide(self) -> bool:
        """True if a table has more columns than fit on half of the page's width."""
        tables = (table for column in (*self.columns, *self.details) for table in column.tables)
        return any(len(table.head) > _HALF for table in tables)


@dataclass(frozen=True, slots=True)
class Page:
    """Content of a report."""

    title: str
    heading: str
    intro: str
    badges: Sequence[str]
    command: str
    versions: Mapping[str, str]
    sections: Sequence[Section]
    how: Sequence[tuple[str, Sequence[str]]]
    warning: str = ""
    notice: tuple[str, str] | None = None
    outcome: Sequence[str] = ()
    claims: Table | None = None
    claims_text: str = ""
    left_out: Sequence[tuple[str, Sequence[str]]] = ()
    several: bool = False

    def html(self) -> str:
        r"""Return the page in HTML. Control characters are shown as text such as ``\u001b``."""
        # Names of files, recordings and plug-ins need be neither UTF-8 nor free of escapes.
        return sanitize(_template().render(page=self))


@cache
def _template() -> Template:
    # Compiled once: a study writes its page after each step.
    from jinja2 import Environment, StrictUndefined

    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    text = files("firstcontact_lab.report").joinpath("report.html").read_text(encoding="utf-8")
    return environment.from_string(text)
