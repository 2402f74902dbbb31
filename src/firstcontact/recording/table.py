"""Readers of CSV files with a header line, written by programs or by people."""

from __future__ import annotations

import csv
import re
import unicodedata
from array import array
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from io import BytesIO, TextIOWrapper
from itertools import chain, islice
from pathlib import Path
from typing import Any, TypeVar

from firstcontact.core import FileError, InputError
from firstcontact.core.files import files_below, open_regular, read_regular
from firstcontact.core.quantity import MODULUS, STIFFNESS
from firstcontact.core.text import counted, parse_float
from firstcontact.recording.settings import LAYOUT
from firstcontact.recording.untrusted import quote

T = TypeVar("T")

#: Largest list that people write, bytes.
LONGEST_LIST = 1 << 20
#: Other separators that programs write between fields.
_OTHER_SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars"}
#: Starts of lines that are comments, unless they are rows or the header.
_COMMENTS = ("#", "%")
#: Number of lines among which the header is looked for.
_AHEAD = 200
#: Characters of empty cells. Loggers that lose their power leave zero bytes at the end.
_BLANK = " \t\0"
#: Name of a column with its unit: "piezo (mV)", "time [ms]", "time_ms" or "piezo_index_mV".
_WITH_UNIT = re.compile(
    r"(.*?)(?:\s*[(\[](.+)[)\]]|_(ms|us|\u00b5s|\u03bcs|mV|uV|\u00b5V|\u03bcV|V|m?g|m/s2|m/s\^2))"
)
#: Units of time, s. Columns named "time" or "onset" are converted to "time_s" and "onset_s".
_SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "\u00b5s": 1e-6, "\u03bcs": 1e-6}
_TIMES = ("time", "onset")
#: Names of columns with a unit, and ours.
_WITH_UNITS = {
    "t": "time",
    "timestamp": "time",
    "stiffness": STIFFNESS.name,
    **dict.fromkeys(("modulus", "youngs_modulus", "young's_modulus", "e_modulus"), MODULUS.name),
}


class Table(dict[str, Sequence[Any]]):
    """Columns of a CSV file by name: lists of cells.

    ``numbers`` has each row's line number in the file, which messages call ``word``.
    ``units`` has the units in the header, by column.
    """

    def __init__(
        self,
        path: Path,
        columns: Mapping[str, Sequence[Any]],
        numbers: Sequence[int],
        word: str = "line",
        units: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(columns)
        self.path, self.numbers, self.word, self.units = path, numbers, word, units or {}

    def place(self, row: int) -> str:
        """Return the position of a row for messages, such as "line 7"."""
        return f"{self.word} {self.numbers[row]}"

    def of_rows(self, rows: Sequence[int]) -> Table:
        columns = {name: [cells[row] for row in rows] for name, cells in self.items()}
        return Table(self.path, columns, [self.numbers[row] for row in rows], self.word, self.units)

    def with_columns(self, columns: Mapping[str, Sequence[Any]]) -> Table:
        return Table(self.path, {**self, **columns}, self.numbers, self.word, self.units)

    def refusal(
        self, name: str, row: int, reason: object, remedy: str = "correct it"
    ) -> InputError:
        """Return the FileError for an unusable cell, with its position, ``reason`` and ``remedy``.

        ``reason`` continues a sentence: "which is not a number".
        """
        cell = quote(self[name][row])
        return FileError(
            f"{self.path}: '{name}' of {self.place(row)} is {cell}, {reason}: {remedy}"
        )

    def parsed(
        self, name: str, parse: Callable[[Any], T], rows: Iterable[int] | None = None
    ) -> list[T]:
        """Return the cells of a column, parsed by ``parse``, of all or some ``rows``.

        If ``parse`` raises ValueError, raise a FileError that names the cell.
        """
        values = []
        cells = self[name]
        for row in range(len(cells)) if rows is None else rows:
            try:
                values.append(parse(cells[row]))
            except (ValueError, TypeError, OverflowError) as error:
                raise self.refusal(name, row, error) from None
        return values


def read_columns(path: Path, *marks: str) -> Table:
    """Read a CSV file that a program wrote, with one header line and equally long rows.

    The header is the first line with one of the column names ``marks``, or else the first line.
    Raises FileError if the file is not such a table.
    """
    lines = _read_lines(path, marks)
    _, header = next(lines)
    columns: list[list[str]] = [[] for _ in header]
    same: dict[str, str] = {}  # cells repeat: store each text once
    numbers = array("q")
    for line, row in lines:
        if len(row) != len(header):
            raise FileError(
                f"{path}: line {line} has {len(row)} fields, but the header has {len(header)}: "
                "correct the line"
            )
        numbers.append(line)
        for column, cell in zip(columns, row, strict=True):
            column.append(same.setdefault(cell, cell))
    if not numbers:
        raise FileError(f"{path} has no rows: give a header and one row at least")
    is_export = LAYOUT in header
    units: dict[str, str] = {}
    given: dict[str, list[str]] = {}
    for written, cells in zip(header, columns, strict=True):
        if not written and not any(map(_text, cells)):
            continue
        # An export names its channels with endings that look like units, but not in brackets.
        as_written = is_export and "(" not in written
        name, unit = (written, "") if as_written else _name_and_unit(written)
        name = _WITH_UNITS.get(name, name) if unit else name
        if unit in _SECONDS and name in _TIMES:
            name, cells, unit = f"{name}_s", [_scale_number(c, _SECONDS[unit]) for c in cells], ""
        if name in given:
            raise FileError(f"{path} has the column {name!r} twice: rename or remove one")
        given[name] = cells
        units |= {name: unit} if unit else {}
    return Table(path, given, numbers, units=units)


def read_rows(path: Path, needed: Sequence[str]) -> list[tuple[int, dict[str, str]]]:
    """Read a CSV file that a person wrote, in which rows may be short.

    Return each row's line number, and its cells by column name. Raises FileError if a column of
    ``needed`` is missing.
    """
    lines = _read_lines(path, needed, by_hand=True)
    _, names = next(lines)
    header = [*map(_plain_name, names)]
    rows = [(line, [*map(_text, row), *[""] * len(header)]) for line, row in lines]
    for name in needed:
        if name not in header:
            raise FileError(f"{path}: column {name!r} is missing: give {', '.join(needed)}")
    for k in (k for k, name in enumerate(header) if not name):
        line = next((line for line, cells in rows if cells[k]), None)
        if line is not None:
            raise FileError(f"{path}: line {line} has a cell in a column without a name: name it")
    return [
        (line, {name: cell for name, cell in zip(header, cells, strict=False) if name})
        for line, cells in rows
    ]


def _text(cell: str) -> str:
    return cell.strip(_BLANK)


def _plain_name(name: str) -> str:
    """Return a column's name in this package's spelling: "Shore A" becomes "shore_a"."""
    return re.sub(r"[\s-]+", "_", _text(name).lower())


def _name_and_unit(name: str) -> tuple[str, str]:
    match = _WITH_UNIT.fullmatch(name)
    return (
        (_plain_name(match[1]), match[2] or match[3])
        if match and match[1]
        else (_plain_name(name), "")
    )


def _scale_number(cell: str, factor: float) -> str:
    """Multiply the number in a cell by ``factor``, and return it as text.

    A cell without a number is returned unchanged.
    """
    try:
        return repr(parse_float(cell) * factor)
    except ValueError:
        return cell


def _read_lines(
    path: Path, marks: Sequence[str], *, by_hand: bool = False
) -> Iterator[tuple[int, list[str]]]:
    """Yield (line number, cells) of each line in a CSV file, the header first.

    The header is the first line with one of the names ``marks``. Empty lines and comments are
    skipped. ``by_hand`` is True for files that a person wrote. Raises
    FileError if the file is not CSV in UTF-8.
    """
    try:
        raw = BytesIO(read_regular(path, LONGEST_LIST)) if by_hand else open_regular(path)
        with TextIOWrapper(raw, encoding="utf-8-sig", newline="") as stream:
            reader = csv.reader(stream, strict=not by_hand, skipinitialspace=by_hand)
            lines = ((reader.line_num, row) for row in reader if any(map(_text, row)))
            ahead = list(islice(lines, _AHEAD))
            place, header = _find_header(path, ahead, marks)
            width = len(header)
            yield (ahead[place][0] if ahead else 0), header
            for line, row in chain(ahead[place + 1 :], lines):
                if len(row) > width and not any(map(_text, row[width:])):
                    del row[width:]
                if len(row) == width or not row[0].startswith(_COMMENTS):
                    yield line, row
    except OSError as error:
        raise FileError(f"{path} cannot be read ({error.strerror}): check the path") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise FileError(
            f"{path} is not CSV in UTF-8 ({error}): save it as CSV with the encoding UTF-8"
        ) from error


def _find_header(
    path: Path, ahead: Sequence[tuple[int, list[str]]], marks: Sequence[str]
) -> tuple[int, list[str]]:
    """Find the header among the first lines of a file, by the column names ``marks``.

    Return its index in ``ahead``, and its cells without spaces around them. ``ahead`` has (line
    number, cells) of these lines. Raises FileError if the file does not use commas.
    """
    first = None
    for place, (line, row) in enumerate(ahead):
        is_comment = row[0].startswith(_COMMENTS)
        # NumPy writes the header as a comment.
        header = [_text(row[0].lstrip("#% ") if is_comment else row[0]), *map(_text, row[1:])]
        if any(_name_and_unit(name)[0] in marks for name in header):
            return place, header
        if first is None and not is_comment:
            first = place, header
        for separator, word in _OTHER_SEPARATORS.items():
            names = header[0].split(separator)
            is_mark = any(_name_and_unit(_text(name))[0] in marks for name in names)
            if len(row) == 1 and len(names) > 1 and (is_mark or (first or (-1,))[0] == place):
                raise FileError(
                    f"{path}: line {line} has {word} and no comma: save it with commas between "
                    "the fields, and with decimal points in numbers"
                )
    return first or (0, [])


def match_files(
    folder: Path, table: Table, *suffixes: str
) -> tuple[list[Path], list[int], list[Path]]:
    """Match the rows of a table with the files in a folder, by the column "file".

    Return the files that rows name, the number (index) of each row's file, and the files that no
    row names. Raises FileError for a row without exactly one file.
    """
    if "file" not in table:
        raise FileError(
            f"{table.path} has no column 'file': add it, with the name of a file in each row"
        )
    available = [file for suffix in suffixes for file in files_below(folder, suffix)]
    by_name: dict[str, list[Path]] = {}
    by_key: dict[str, list[Path]] = {}  # as other systems write the names
    for file in available:
        for name in {file.name, file.relative_to(folder).as_posix()}:
            by_name.setdefault(name, []).append(file)
            by_key.setdefault(file_key(name), []).append(file)
    files: dict[Path, int] = {}
    numbers = []
    for row, name in enumerate(table["file"]):
        matches = by_name.get(name.strip()) or by_key.get(file_key(name), [])
        if len(matches) != 1:
            fault = (
                f"the name of {len(matches)} files" if matches else f"not in the folder {folder}"
            )
            raise table.refusal("file", row, f"which is {fault}", "correct the row or the folder")
        numbers.append(files.setdefault(matches[0], len(files)))
    return list(files), numbers, [file for file in available if file not in files]


def file_key(name: str) -> str:
    """Return a file name or path in one spelling, without differences in case and separators."""
    path = unicodedata.normalize("NFC", name).strip().replace("\\", "/")
    return Path(path).as_posix().casefold()


def is_file(name: str, path: Path) -> bool:
    """Return True if ``name`` is the end of ``path``: the file name, perhaps with folders."""
    return f"/{file_key(str(path))}".endswith(f"/{file_key(name)}")


def match_each_file(folder: Path, table: Table, suffix: str) -> list[Path]:
    """Return the file of each row. Raise FileError unless each file has exactly one row."""
    files, numbers, left = match_files(folder, table, suffix)
    if len(files) < len(numbers):
        ((number, _),) = Counter(numbers).most_common(1)
        raise FileError(f"{table.path}: file {files[number].name!r} has two rows: remove one")
    if left:
        raise FileError(
            f"{table.path} has no row for {counted(len(left), f'{suffix} file')} (first: "
            f"{left[0].name!r}): add the rows or remove the files"
        )
    return files
