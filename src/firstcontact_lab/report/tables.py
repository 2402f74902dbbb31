"""Tables of reports and docs, and the row definitions that make them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, NamedTuple, Protocol, TypeVar

from firstcontact.core.text import percent
from firstcontact.models.scores import Ends

R = TypeVar("R")
S = TypeVar("S")


class Scores(Protocol):
    """Interface of records that hold scores and an interval for each score."""

    @property
    def intervals(self) -> dict[str, Ends]:
        """Lower and upper bound of the interval of each score, by the name of the score."""
        ...


class Bounded(NamedTuple):
    value: float
    ends: Ends | None = None


def bounded(scores: Scores | None, name: str) -> Bounded | None:
    """Return the score ``name`` of a record with its interval, or None if it was not measured."""
    value = getattr(scores, name, None)
    return None if scores is None or value is None else Bounded(value, scores.intervals.get(name))


#: A value with or without an interval, a text, or None where it is not known.
Value = float | Bounded | str | None

ABSENT = "–"


@dataclass(frozen=True, slots=True)
class Cell:
    text: str
    small: str = ""


@dataclass(frozen=True, slots=True)
class Line:
    """Line of a table. A *quiet* line has a pale colour."""

    cells: Sequence[Cell]
    quiet: bool = False


@dataclass(frozen=True, slots=True)
class Table:
    caption: str
    head: Sequence[str]
    lines: Sequence[Line]


@dataclass(frozen=True, slots=True)
class Claim:
    value: float
    tolerance: float
    lower: bool = False

    def verdict(self, value: Value, unit: str) -> str:
        if value is None or isinstance(value, str):
            return ""
        bounded = value if isinstance(value, Bounded) else Bounded(value)
        difference = abs(bounded.value - self.value)
        if difference <= self.tolerance + 1e-9:
            return "reproduced"
        direction = "better" if (bounded.value < self.value) == self.lower else "worse"
        low, high = bounded.ends or (bounded.value, bounded.value)
        included = ", not excluded" if low <= self.value <= high else ""
        return f"{direction} by {_DIFFERENCES.get(unit, UNITS[unit])(difference)}{included}"


@dataclass(frozen=True)
class Row(Generic[R]):
    """Definition of a table row: a function that finds a number in results, and its format."""

    label: str
    value: Callable[[R], Value]
    unit: str = "count"
    published: str = ABSENT
    headline: bool = False
    claim: Claim | None = None
    note: Callable[[R], str] | None = None

    def cell(self, results: R) -> Cell:
        return format_cell(self.value(results), self.unit)


def number(value: float, digits: int, sign: str = "") -> str:
    """Return ``value`` as text with ``digits`` decimals and a typographic minus sign.

    Zero has no sign.
    """
    text = f"{value:{sign}.{digits}f}"
    if float(text) == 0.0:
        text = text.lstrip("+-")
    return text.replace("-", "−")


UNITS: Mapping[str, Callable[[float], str]] = {
    "count": lambda value: f"{value:,.0f}",
    "rate": lambda value: f"{value:,.1f}" if value < 100 else f"{value:,.0f}",
    "ms": lambda value: f"{number(value, 2)} ms",
    "us": lambda value: f"{value:,.0f} µs",
    "s": lambda value: f"{value:.0f} s",
    "hz": lambda value: f"{value:g} Hz",
    "ratio": lambda value: f"{value:.1f} ×",
    "shore": lambda value: number(value, 2),
    "bias": lambda value: number(value, 2, "+"),
    "square": lambda value: number(value, 1),
    "rho": lambda value: number(value, 2),
    "p": lambda value: f"{value:.3f}",
    "share": percent,
    "whole": lambda value: percent(value, 0).replace("-", "−"),
    "gain": lambda value: f"{number(100 * value, 0, '+')} %",
    "newton": lambda value: f"{value:.2f} N",
    "whole ms": lambda value: f"{value:.0f} ms",
    "one": lambda value: number(value, 1),
}

#: Format of differences from a published value, by unit.
_DIFFERENCES: Mapping[str, Callable[[float], str]] = {
    "share": lambda value: f"{number(100 * value, 1)} points",
    "shore": lambda value: f"{number(value, 2)} Shore A",
}
#: Largest differences from a published share, and from a published error as a share of this error,
#: that count as reproduced.
SHARE_TOLERANCE, ERROR_TOLERANCE = 0.02, 0.1
VERDICTS = (
    f"Reproduced: a share within {100 * SHARE_TOLERANCE:.0f} points, an error within "
    f"{100 * ERROR_TOLERANCE:.0f} %. Not excluded: our interval (small numbers, bars; nominally "
    "95 %, but over 6 to 12 objects it holds the true value in 85 to 87 % of cases) includes the "
    "published value. “MSE”: the paper's word, but it gives Shore A; as MSEs, 4.17 "
    "and 2.39 are RMSEs of 2.04 and 1.55."
)


def format_cell(value: Value, unit: str) -> Cell:
    """Return a table cell that shows ``value``. If it has an interval, small print shows it."""
    if value is None:
        return Cell(ABSENT)
    if isinstance(value, str):
        return Cell(value)
    bounded = value if isinstance(value, Bounded) else Bounded(value)
    form = UNITS[unit]
    ends = " to ".join(form(end).split(" ")[0] for end in bounded.ends or ())
    return Cell(form(bounded.value), ends)


def optional(find: Callable[[R], S | None], value: Callable[[S], Value]) -> Callable[[R], Value]:
    """Return a function from results to ``value(record)``, where ``find(results)`` is the record.

    The function returns None if ``find`` returns None.
    """

    def from_results(results: R) -> Value:
        record = find(results)
        return None if record is None else value(record)

    return from_results


def row_table(
    rows: Iterable[Row[R]], subjects: Mapping[str, R], caption: str = "", *, published: bool = False
) -> Table:
    lines = []
    for row in rows:
        cells = [row.cell(results) for results in subjects.values()]
        if all(cell.text == ABSENT for cell in cells):
            continue
        beside = [Cell(row.published)] if published else []
        lines.append(Line([Cell(row.label), *beside, *cells]))
    return Table(caption, ["", *(["published"] if published else []), *subjects], lines)


def claims_table(rows: Iterable[Row[R]], subjects: Mapping[str, R]) -> Table:
    """Return a table of the rows that have a published claim or a note, or are headlines.

    The last column has the verdict on the claim.
    """
    chosen = [row for row in rows if row.claim or row.note or row.headline]
    table = row_table(chosen, subjects, published=True)
    by_label = {row.label: row for row in chosen}
    lines = [
        Line([*line.cells, Cell(_verdict(by_label[line.cells[0].text], subjects))])
        for line in table.lines
    ]
    return Table("", [*table.head, "verdict"], lines)


def _verdict(row: Row[R], subjects: Mapping[str, R]) -> str:
    values = {title: row.value(results) for title, results in subjects.items()}
    compared = {t: row.claim.verdict(v, row.unit) for t, v in values.items() if row.claim}
    notes = {t: row.note(subjects[t]) for t, v in values.items() if row.note and v is not None}
    verdict, note = _join_texts(compared), _join_texts(notes)
    if verdict and note:
        return f"{verdict}. {note[0].upper()}{note[1:]}"
    return verdict or note or "not in the paper"


def _join_texts(texts: Mapping[str, str]) -> str:
    """Return the texts of several datasets in one line, each after the title of its dataset.

    If all texts are equal, return the text once, without a title.
    """
    present = {title: text for title, text in texts.items() if text}
    if len(set(present.values())) == 1:
        return next(iter(present.values()))
    return "; ".join(f"{title.lower()}: {text}" for title, text in present.items())


def join_side_by_side(tables: Mapping[str, Table], heads: Sequence[str] = ()) -> Table:
    """Return one table with the columns of the tables of several datasets side by side.

    ``heads`` has the titles of the columns to keep. If it is empty, all are kept.
    """
    head = [""]
    blocks: list[tuple[int, dict[tuple[str, str], Line]]] = []
    names: dict[tuple[str, str], Cell] = {}
    counts = [Counter(line.cells[0].text for line in table.lines) for table in tables.values()]
    for title, table in tables.items():
        chosen = [
            place for place, name in enumerate(table.head) if place and (not heads or name in heads)
        ]
        subject = title.lower() if len(tables) > 1 else ""
        head += [", ".join(filter(None, (table.head[place], subject))) for place in chosen]
        lines: dict[tuple[str, str], Line] = {}
        seen: Counter[str] = Counter()
        for line in table.lines:
            name = line.cells[0]
            seen[name.text] += 1
            # Details may hold numbers of the subject: use them only if names alone do not tell
            # lines apart.
            alike = len({count[name.text] for count in counts}) == 1
            key = name.text, str(seen[name.text]) if alike else name.small
            lines[key] = Line([line.cells[place] for place in chosen], line.quiet)
            names.setdefault(key, name)
        blocks.append((len(chosen), lines))
    merged = []
    for key, named in names.items():
        present = [lines.get(key) for _, lines in blocks]
        cells = [
            cell
            for line, (width, _) in zip(present, blocks, strict=True)
            for cell in (line.cells if line else [Cell(ABSENT)] * width)
        ]
        merged.append(Line([named, *cells], any(line.quiet for line in present if line)))
    caption = next(iter(tables.values())).caption if len(tables) == 1 else ""
    return Table(caption, head, merged)


def matrix(
    caption: str, rows: Sequence[Row[R]], entries: Iterable[tuple[Cell, R | None, bool]]
) -> Table | None:
    present = [(name, record, quiet) for name, record, quiet in entries if record is not None]
    columns = [
        row
        for row in rows
        if any(row.cell(row_record).text != ABSENT for _, row_record, _ in present)
    ]
    if not columns:
        return None
    lines = [
        Line([name, *(row.cell(record) for row in columns)], quiet)
        for name, record, quiet in present
    ]
    return Table(caption, ["", *(row.label for row in columns)], lines)


def row_for_results(
    row: Row[S],
    prefix: str,
    find: Callable[[R], S | None],
    published: str = ABSENT,
    headline: bool = False,
    claim: Claim | None = None,
    note: Callable[[R], str] | None = None,
) -> Row[R]:
    """Return a row that takes whole results, made from ``row``, which takes one record in them.

    ``find`` returns the record from the results. ``prefix`` is put before the label of the row.
    """
    value = optional(find, row.value)
    return Row(prefix + row.label, value, row.unit, published, headline, claim, note)


def markdown(table: Table) -> str:
    rows = ([_written(cell) for cell in line.cells] for line in table.lines)
    return markdown_table(" | ".join(table.head), rows)


def markdown_table(head: str, rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown. ``head`` has the column titles, separated by vertical bars."""
    columns = head.split(" | ")
    lines = (columns, ["---"] * len(columns), *rows)
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def fill(text: str, kind: str, made: Mapping[str, str]) -> str:
    """Return the page ``text`` with new text between its markers.

    The markers are ``<!-- KIND: NAME -->`` and ``<!-- /KIND -->``. ``made`` has the new text by
    NAME.
    """
    pattern = rf"(<!-- {kind}: (\w+) -->\n).*?(<!-- /{kind} -->)"
    page, count = re.subn(
        pattern, lambda m: f"{m[1]}\n{made[m[2]].rstrip()}\n\n{m[3]}", text, flags=re.DOTALL
    )
    if not count:
        raise ValueError(f"the page has no place for a table: <!-- {kind}: NAME -->")
    return page


def plain_lines(table: Table) -> list[str]:
    """Return a table as lines of text with aligned columns, without small print."""
    texts = [table.head, *([cell.text for cell in line.cells] for line in table.lines)]
    widths = [max(map(len, column)) for column in zip(*texts, strict=True)]
    lines = []
    for row in texts:
        first, *columns = (text.rjust(w) for text, w in zip(row, widths, strict=True))
        lines.append("  ".join([first.strip().ljust(widths[0]), *columns]).rstrip())
    return lines


def _written(cell: Cell) -> str:
    return f"{cell.text} ({cell.small})" if cell.small else cell.text
