r"""Label tracks of Audacity: one line ``start<TAB>end<TAB>text`` per label, in seconds.

The text of a label (or of an XDF marker) is the name of the object, or ``name=value`` for any
column of labels. Semicolons separate several labels: ``eraser; shore_a=40``.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from firstcontact.core import InputError, parse_float, read_regular
from firstcontact.recording._labels import LABEL_COLUMNS
from firstcontact.recording._quoting import quote, reason
from firstcontact.recording._table import Table

#: Largest track, bytes: more than a hundred thousand labels.
LONGEST_TRACK = 1 << 24
#: Prefix of lines with the frequency range of the label on the line before.
_FREQUENCIES = "\\"
#: Column with the start of a label.
ONSET = "onset_s"


def is_track(path: Path) -> bool:
    """Return True if the file name of a table of contacts is that of a label track."""
    return path.suffix.lower() == ".txt"


def read_track(path: Path) -> Table:
    """Read the labels of a track as columns of a table of contacts."""
    try:
        text = read_regular(path, LONGEST_TRACK).decode("utf-8-sig")
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror}): check the path") from error
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path} is not an Audacity label track in UTF-8 ({reason(error)}): export it from "
            "Audacity again"
        ) from error
    starts: list[str] = []
    texts: list[str] = []
    numbers: list[int] = []
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.startswith(_FREQUENCIES):
            continue
        fields = line.split("\t")
        try:
            # Some languages use a decimal comma.
            start, end = (parse_float(field.replace(",", ".")) for field in fields[:2])
        except ValueError:
            start, end = 1.0, 0.0
        if not start <= end:
            raise InputError(
                f"{path}: line {number} is {quote(line)}, which is no label: give start and end in "
                "seconds and a text, with tabs between"
            )
        numbers.append(number)
        starts.append(f"{start!r}")
        texts.append(" ".join(fields[2:]).strip())
    if not starts:
        raise InputError(f"{path} has no labels: give one line for each contact")
    return label_columns(str(path), Table({ONSET: starts}, numbers), texts)


def label_columns(origin: str, table: Table, texts: Sequence[str]) -> Table:
    """Return the table with a column added for each label in ``texts``, one text per row."""
    rows: list[dict[str, str]] = []
    for number, text in enumerate(texts):
        row: dict[str, str] = {}
        for part in filter(None, map(str.strip, text.split(";"))):
            name, equals, value = (word.strip() for word in part.partition("="))
            name, value = (name, value) if equals else ("object", part)
            if name not in LABEL_COLUMNS or name in row:
                raise InputError(
                    f"{origin}: {table.place(number)} has the unknown or repeated label "
                    f"{quote(part)}. Write the object's name, or name=value pairs separated by "
                    f"semicolons; names: {', '.join(LABEL_COLUMNS)}"
                )
            row[name] = value
        rows.append(row)
    names = [name for name in LABEL_COLUMNS if any(name in row for row in rows)]
    for name in names:
        lacking = next((i for i, row in enumerate(rows) if name not in row), None)
        if lacking is not None and name != "object":
            raise InputError(
                f"{origin}: {table.place(lacking)} has no '{name}', but other lines have one: "
                "give it in all lines, or in none"
            )
    cells = {name: [row.get(name, "") for row in rows] for name in names}
    return Table({**table, **cells}, table.numbers, table.word)
