"""CSV files with a header line: tables that programs write, and lists that people write."""

from __future__ import annotations

import csv
from array import array
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from io import BytesIO, TextIOWrapper
from pathlib import Path
from typing import Any, TypeVar

from firstcontact.core import InputError
from firstcontact.core.files import files_below, open_regular, read_regular
from firstcontact.core.text import counted
from firstcontact.recording.untrusted import quote

T = TypeVar("T")

#: Largest list that people write, bytes.
LONGEST_LIST = 1 << 20
#: Other separators that programs write between fields.
_OTHER_SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars"}


class Table(dict[str, Sequence[Any]]):
    """Columns by name. For messages it knows its file, and the line of each row."""

    def __init__(
        self,
        path: Path,
        columns: Mapping[str, Sequence[Any]],
        numbers: Sequence[int],
        word: str = "line",
    ) -> None:
        super().__init__(columns)
        self.path, self.numbers, self.word = path, numbers, word

    def place(self, row: int) -> str:
        """Return the position of a row for messages: "line 7"."""
        return f"{self.word} {self.numbers[row]}"

    def of_rows(self, rows: Sequence[int]) -> Table:
        """Return a table of some rows."""
        columns = {name: [cells[row] for row in rows] for name, cells in self.items()}
        return Table(self.path, columns, [self.numbers[row] for row in rows], self.word)

    def with_columns(self, columns: Mapping[str, Sequence[Any]]) -> Table:
        """Return a table with further or changed columns."""
        return Table(self.path, {**self, **columns}, self.numbers, self.word)

    def refusal(
        self, name: str, row: int, reason: object, remedy: str = "correct it"
    ) -> InputError:
        """Return the error for a cell."""
        cell = quote(self[name][row])
        return InputError(
            f"{self.path}: '{name}' of {self.place(row)} is {cell}, {reason}: {remedy}"
        )

    def parsed(
        self, name: str, parse: Callable[[Any], T], rows: Iterable[int] | None = None
    ) -> list[T]:
        """Return the parsed cells of a column. An error of ``parse`` becomes one about the cell."""
        values = []
        cells = self[name]
        for row in range(len(cells)) if rows is None else rows:
            try:
                values.append(parse(cells[row]))
            except (ValueError, TypeError, OverflowError) as error:
                raise self.refusal(name, row, error) from None
        return values


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
    if not numbers:
        raise InputError(f"{path} has no rows: give a header and one row at least")
    doubled = sorted(name for name, times in Counter(header).items() if times > 1)
    if doubled:
        raise InputError(f"{path} has the column {doubled[0]!r} twice: rename or remove one")
    return Table(path, dict(zip(header, columns, strict=True)), numbers)


def read_rows(path: Path, needed: Sequence[str]) -> list[tuple[int, dict[str, str]]]:
    """Read a list that people write, row by row."""
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
            for separator, name in _OTHER_SEPARATORS.items():
                if len(header) == 1 and separator in header[0]:
                    raise InputError(
                        f"{path}: line 1 has {name} and no comma: save it with commas between the "
                        "fields, and with decimal points in numbers"
                    )
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


def match_files(
    folder: Path, table: Table, *suffixes: str
) -> tuple[list[Path], list[int], list[Path]]:
    """Return the files that the rows name, the file number of each row, and the other files."""
    if "file" not in table:
        raise InputError(
            f"{table.path} has no column 'file': add it, with the name of a file in each row"
        )
    available = [file for suffix in suffixes for file in files_below(folder, suffix)]
    by_name: dict[str, list[Path]] = {}
    for file in available:
        for name in {file.name, file.relative_to(folder).as_posix()}:
            by_name.setdefault(name, []).append(file)
    files: dict[Path, int] = {}
    numbers = []
    for row, name in enumerate(table["file"]):
        matches = by_name.get(name.strip(), [])
        if len(matches) != 1:
            fault = "in two folders" if matches else f"not in the folder {folder}"
            raise table.refusal("file", row, f"which is {fault}", "correct the row or the folder")
        numbers.append(files.setdefault(matches[0], len(files)))
    return list(files), numbers, [file for file in available if file not in files]


def match_each_file(folder: Path, table: Table, suffix: str) -> list[Path]:
    """Return the file of each row. Each file with the suffix must have exactly one row."""
    files, numbers, left = match_files(folder, table, suffix)
    if len(files) < len(numbers):
        ((number, _),) = Counter(numbers).most_common(1)
        raise InputError(f"{table.path}: file {files[number].name!r} has two rows: remove one")
    if left:
        raise InputError(
            f"{table.path} has no row for {counted(len(left), f'{suffix} file')} (first: "
            f"{left[0].name!r}): add the rows or remove the files"
        )
    return files
