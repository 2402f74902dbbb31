"""CSV files with a header line: tables that programs write, and lists that people write."""

from __future__ import annotations

import csv
from array import array
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from io import BytesIO, TextIOWrapper
from pathlib import Path

from firstcontact.core import InputError, open_regular, read_regular

#: Largest number of columns.
MOST_COLUMNS = 1000
#: Largest list that people write, bytes.
LONGEST_LIST = 1 << 20


#: Other separators that programs write between fields.
_OTHER_SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars"}


class Table(dict[str, list[str]]):
    """Columns by name, with the line of each row for messages."""

    def __init__(
        self, columns: Mapping[str, list[str]], numbers: Sequence[int], word: str = "line"
    ) -> None:
        super().__init__(columns)
        self.numbers, self.word = numbers, word

    def place(self, row: int) -> str:
        """Return the position of a row for messages: "line 7"."""
        return f"{self.word} {self.numbers[row]}"

    def of_rows(self, columns: Mapping[str, list[str]], rows: Sequence[int]) -> Table:
        """Return a table of ``columns``, whose cells come from the rows ``rows`` of this table."""
        return Table(columns, [self.numbers[row] for row in rows], self.word)


def read_columns(path: Path) -> Table:
    """Return the columns of a CSV with a header line."""
    lines = _lines(path)
    _, header = next(lines)
    columns: list[list[str]] = [[] for _ in header]
    same: dict[str, str] = {}  # cells repeat: store each text once
    numbers = array("q")
    for line, row in lines:
        if len(row) != len(header):
            raise InputError(
                f"{path}: line {line} has {len(row)} fields, but the header has {len(header)}: "
                "correct the line"
            )
        numbers.append(line)
        for column, cell in zip(columns, row, strict=True):
            column.append(same.setdefault(cell, cell))
    if not columns or not columns[0]:
        raise InputError(f"{path} has no rows: give a header and one row at least")
    doubled = sorted(name for name, times in Counter(header).items() if times > 1)
    if doubled:
        raise InputError(f"{path} has the column {doubled[0]!r} twice: rename or remove one")
    return Table(dict(zip(header, columns, strict=True)), numbers)


def read_rows(path: Path, needed: Sequence[str]) -> list[tuple[int, dict[str, str]]]:
    """Read a list that people write, row by row.

    Blanks around names and cells are removed. Extra cells are ignored, and missing cells are "".

    Parameters
    ----------
    path
        Path of the file.
    needed
        Required columns.

    Returns
    -------
    list
        Line of each row in the file, and its cells by column.

    Raises
    ------
    InputError
        The file cannot be read, is longer than 1 MiB, or lacks a column.
    """
    lines = _lines(path, by_hand=True)
    _, header = next(lines)
    rows = [(line, [*map(str.strip, row), *[""] * len(header)]) for line, row in lines]
    for name in needed:
        if name not in header:
            raise InputError(f"{path}: column {name!r} is missing: give {', '.join(needed)}")
    return [(line, dict(zip(header, cells, strict=False))) for line, cells in rows]


def _lines(path: Path, *, by_hand: bool = False) -> Iterator[tuple[int, list[str]]]:
    """Yield the number and cells of each line that is not empty, the header first."""
    try:
        raw = BytesIO(read_regular(path, LONGEST_LIST)) if by_hand else open_regular(path)
        with TextIOWrapper(raw, encoding="utf-8-sig", newline="") as stream:
            reader = csv.reader(stream, strict=not by_hand, skipinitialspace=by_hand)
            header = [name.strip() for name in next(reader, [])]
            if len(header) > MOST_COLUMNS:
                raise InputError(
                    f"{path} has {len(header)} columns, more than {MOST_COLUMNS}: give a table "
                    "with a header"
                )
            _check_separator(path, header)
            yield reader.line_num, header
            for row in reader:
                if row:
                    yield reader.line_num, row
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror}): check the path") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(
            f"{path} is not CSV in UTF-8 ({error}): save it as CSV with the encoding UTF-8"
        ) from error


def _check_separator(path: Path, header: Sequence[str]) -> None:
    """Raise an error for a header that uses a separator other than the comma."""
    if len(header) != 1:
        return
    for separator, name in _OTHER_SEPARATORS.items():
        if separator in header[0]:
            raise InputError(
                f"{path}: line 1 has no comma and {header[0].count(separator)} {name}, which seem "
                "to separate the fields: save it with commas between, and with decimal points in "
                "numbers"
            )
