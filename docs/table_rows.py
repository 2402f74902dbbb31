"""Tables of results as Markdown: a row a number, with its interval, or a table on its side."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from firstcontact.core import percent
from firstcontact.models import Bounded
from firstcontact_lab.report._tables import Cell, Table
from firstcontact_lab.report.results.study import SubjectResults

ABSENT = "–"
#: How a kind of value is shown, and what it is multiplied by; a share is shown by `percent`.
FORMS = {
    "count": ("{:.0f}", 1.0),
    "rate": ("{:.1f}", 1.0),
    "ms": ("{:.2f} ms", 1.0),
    "us": ("{:.0f} µs", 1.0),
    "s": ("{:.0f} s", 1.0),
    "ratio": ("{:.1f} times", 1.0),
    "shore": ("{:.2f}", 1.0),
    "p": ("{:.3f}", 1.0),
}


R = TypeVar("R")
S = TypeVar("S")
Number = float | Bounded | None


@dataclass(frozen=True)
class Row(Generic[R]):
    """One row: what it is, its number in some results, what kind it is, what was published."""

    label: str
    number: Callable[[R], Number]
    kind: str
    published: str = ABSENT

    def cell(self, results: R, intervals: bool = True) -> str:
        """The number with its 95 % interval, if it has one and it is wanted, or a dash."""
        found = self.number(results)
        if found is None:
            return ABSENT
        value, ends = found if isinstance(found, Bounded) else Bounded(found)
        shown = self._text(value)
        if intervals and ends:
            low, high = (self._text(end).split(" ")[0] for end in ends)
            shown += f" ({low} to {high})"
        return shown

    def _text(self, value: float) -> str:
        if self.kind == "share":
            return percent(value)
        form, factor = FORMS[self.kind]
        return form.format(factor * value)


def of(find: Callable[[R], S | None], number: Callable[[S], Number]) -> Callable[[R], Number]:
    """A number of a record that need not be there."""

    def found(results: R) -> Number:
        record = find(results)
        return None if record is None else number(record)

    return found


Rows = list[Row[SubjectResults]]


def lined(lines: Iterable[Sequence[str]]) -> str:
    """Lines of cells, of which the second is the rule under the heads."""
    return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


def table(
    rows: Rows, columns: Mapping[str, SubjectResults], published: bool, intervals: bool = True
) -> str:
    """A Markdown table; rows that no column has are left out."""
    head = ["", *(["published"] if published else []), *columns]
    lines = [head, ["---"] * len(head)]
    for row in rows:
        cells = [row.cell(results, intervals) for results in columns.values()]
        if any(cell != ABSENT for cell in cells):
            lines.append([row.label, *([row.published] if published else []), *cells])
    return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


def columns_of(its: Table) -> str:
    """A table on its side: a column for each of its rows."""
    columns = [list(its.head), *([_cell(c) for c in row.cells] for row in its.rows)]
    head, *lines = zip(*columns, strict=True)
    rows = [("", *head[1:]), ("---",) * len(head), *lines]
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def _cell(cell: Cell) -> str:
    return f"{cell.text} ({cell.small})" if cell.small else cell.text
