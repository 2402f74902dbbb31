"""Matching of a table's rows to the files of a folder."""

from __future__ import annotations

from pathlib import Path

from firstcontact.core import InputError, counted, files_below


def files_by_name(folder: Path, *suffixes: str) -> tuple[list[Path], dict[str, list[Path]]]:
    """Return the files with these suffixes, and the files that each name or relative path means."""
    files = [path for suffix in suffixes for path in files_below(folder, suffix)]
    by_name: dict[str, list[Path]] = {}
    for path in files:
        for name in {path.name, path.relative_to(folder).as_posix()}:
            by_name.setdefault(name, []).append(path)
    return files, by_name


def files_of_rows(folder: Path, names: list[str], table: Path, suffix: str) -> list[Path]:
    """Return the file of each row. Each file with the suffix must have exactly one row."""
    available, by_name = files_by_name(folder, suffix)
    files: dict[Path, None] = {}  # in the order of the rows
    for name in names:
        matches = by_name.get(name.strip(), [])
        if len(matches) != 1:
            fault = "is in two folders" if matches else "is not in the folder"
            raise InputError(f"{table}: file {name!r} {fault}: correct the row or the folder")
        if matches[0] in files:
            raise InputError(f"{table}: file {name!r} has two rows: remove one")
        files[matches[0]] = None
    left = [p.name for p in available if p not in files]
    if left:
        kind = suffix.removeprefix(".").upper()
        raise InputError(
            f"{table}: {counted(len(left), f'{kind} file')} {'has' if len(left) == 1 else 'have'} "
            f"no row (first: {left[0]!r}): "
            "add the rows or remove the files"
        )
    return list(files)
