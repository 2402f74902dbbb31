r"""Label tracks as Audacity exports them: ``start<TAB>end<TAB>text`` in seconds, a line each.

The text of a label (and of a marker in an XDF file) says what was touched: the object in
plain words, or ``name=value`` of any label, with semicolons between: ``eraser; shore_a=40``.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from firstcontact.core import InputError, parse_float, read_regular
from firstcontact.recording._labels import LABEL_COLUMNS
from firstcontact.recording._quoting import quote, reason
from firstcontact.recording._table import Table

#: Bytes of the longest track: a hundred thousand labels and more.
LONGEST_TRACK = 1 << 24
#: Lines that begin so belong to the label before: its range of frequencies.
_FREQUENCIES = "\\"
#: The column of a label's start.
ONSET = "onset_s"


def is_track(path: Path) -> bool:
    """Whether a table of contacts is a label track, by its name."""
    return path.suffix.lower() == ".txt"


def read_track(path: Path) -> Table:
    """The labels of a track, as columns of a table of contacts.

    Where a label spans a range, its start is the contact.

    Raises
    ------
    InputError
        It cannot be read, or names the line that is no label.
    """
    try:
        text = read_regular(path, LONGEST_TRACK).decode("utf-8-sig")
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror}): check the path") from error
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path} is no label track in UTF-8 ({reason(error)}): export it from Audacity again"
        ) from error
    starts: list[str] = []
    texts: list[str] = []
    numbers: list[int] = []
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.startswith(_FREQUENCIES):
            continue
        fields = line.split("\t")
        try:
            # Some languages write a comma for the point.
            start, end = (parse_float(field.replace(",", ".")) for field in fields[:2])
        except ValueError:
            start, end = 1.0, 0.0
        if not start <= end:
            raise InputError(
                f"{path}: line {number} is {quote(line)} and no label: give start and end in "
                "seconds and a text, with tabs between"
            )
        numbers.append(number)
        starts.append(f"{start!r}")
        texts.append(" ".join(fields[2:]).strip())
    if not starts:
        raise InputError(f"{path} has no labels: give one line for each contact")
    return label_columns(str(path), Table({ONSET: starts}, numbers), texts)


def label_columns(where: str, table: Table, texts: Sequence[str]) -> Table:
    """A table with what the texts of its rows say; a text of plain words is the object.

    Raises
    ------
    InputError
        A ``name=value`` of no label, or one that only some of the texts have.
    """
    rows: list[dict[str, str]] = []
    for number, text in enumerate(texts):
        row: dict[str, str] = {}
        for part in filter(None, map(str.strip, text.split(";"))):
            name, equals, value = (word.strip() for word in part.partition("="))
            name, value = (name, value) if equals else ("object", part)
            if name not in LABEL_COLUMNS or name in row:
                raise InputError(
                    f"{where}: {table.place(number)} says {quote(part)}: give the object in words, "
                    f"or name=value once for any of {', '.join(LABEL_COLUMNS)}, with semicolons "
                    "between"
                )
            row[name] = value
        rows.append(row)
    names = [name for name in LABEL_COLUMNS if any(name in row for row in rows)]
    for name in names:
        lacking = next((i for i, row in enumerate(rows) if name not in row), None)
        if lacking is not None and name != "object":
            raise InputError(
                f"{where}: {table.place(lacking)} does not say {name} and others do: give it in "
                "all, or in none"
            )
    said = {name: [row.get(name, "") for row in rows] for name in names}
    return Table({**table, **said}, table.numbers, table.word)
