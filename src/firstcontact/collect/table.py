"""Lists that people write: a CSV with a line of names."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from io import BytesIO, TextIOWrapper
from pathlib import Path

from firstcontact.core import InputError
from firstcontact.core.files import read_regular

#: People write these by hand: longer is another kind of file, bytes.
LONGEST = 1 << 20


def read_table(path: Path, columns: Sequence[str]) -> list[tuple[int, dict[str, str]]]:
    """Read a CSV in UTF-8 that has at least these columns.

    Blanks around names and cells do not count; a cell beyond the names is left out,
    and one that is not there is "".

    Returns
    -------
    list
        Number of each line in the file, and its cells by column.

    Raises
    ------
    InputError
        The file cannot be read, or misses a column.
    """
    rows = []
    try:
        data = BytesIO(read_regular(path, LONGEST))
        with TextIOWrapper(data, encoding="utf-8-sig", newline="") as stream:
            reader = csv.DictReader(stream, skipinitialspace=True)
            names = [name.strip() for name in reader.fieldnames or ()]
            reader.fieldnames = names
            for row in reader:
                cells = {name: (row[name] or "").strip() for name in names}
                rows.append((reader.line_num, cells))
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror}): check the path") from error
    except InputError:
        raise
    except (ValueError, csv.Error) as error:
        raise InputError(f"{path} is not a CSV in UTF-8 ({error}): save it as one") from error
    for name in columns:
        if name not in names:
            raise InputError(f"{path}: column {name!r} is missing: give {', '.join(columns)}")
    return rows
