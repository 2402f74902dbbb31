"""A CSV file as columns of text."""

from __future__ import annotations

import csv
from collections import Counter
from io import TextIOWrapper
from pathlib import Path

from firstcontact.core import InputError
from firstcontact.core.files import open_regular

#: More columns than any table has that people make.
MOST_COLUMNS = 1000


def read_table(path: Path) -> dict[str, list[str]]:
    """A CSV file with a header as columns of text.

    Raises
    ------
    InputError
        The file cannot be read, has no rows, two columns of one name, or a
        row of another length.
    """
    try:
        with TextIOWrapper(open_regular(path), encoding="utf-8-sig", newline="") as stream:
            reader = csv.reader(stream, strict=True)
            header = [name.strip() for name in next(reader, [])]
            if len(header) > MOST_COLUMNS:
                raise InputError(
                    f"{path} has {len(header)} columns, more than {MOST_COLUMNS}: give a table "
                    "with a header"
                )
            columns: list[list[str]] = [[] for _ in header]
            same: dict[str, str] = {}  # cells repeat: hold each text once
            for row in reader:
                if row and len(row) != len(header):
                    raise InputError(
                        f"{path}: line {reader.line_num} has {len(row)} fields and the header "
                        f"{len(header)}: correct the line"
                    )
                for column, cell in zip(columns, row, strict=False):  # an empty line has no cell
                    column.append(same.setdefault(cell, cell))
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror}): check the path") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path} is not CSV in UTF-8 ({error}): save it as such") from error
    if not columns or not columns[0]:
        raise InputError(f"{path} has no rows: give a header and one row at least")
    doubled = sorted(name for name, times in Counter(header).items() if times > 1)
    if doubled:
        raise InputError(f"{path} has the column {doubled[0]!r} twice: rename or remove one")
    return dict(zip(header, columns, strict=True))
