"""Checks of a table's columns as a whole: the source that they state, and unknown columns."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path

from firstcontact.core import InputError
from firstcontact.recording._checks import check_source
from firstcontact.recording._quoting import listed


def stated_source(table: Path, columns: Mapping[str, list[str]]) -> str:
    """Return the source that a table states; "unknown" if it states none.

    Raises
    ------
    InputError
        The source differs between rows, or is none of those that recordings allow.
    """
    sources = sorted(set(columns.get("source", ["unknown"])))
    if len(sources) > 1:
        raise InputError(
            f"{table}: the column 'source' must be the same in all rows: import each source "
            "separately"
        )
    return check_source(str(table), sources[0])


def unknown_columns(table: Path, columns: Collection[str], names: Collection[str]) -> list[str]:
    """Return a note that lists the unknown columns, if there are any."""
    unknown = sorted(set(columns) - set(names))
    return [f"{table.name}: unknown columns were left out: {listed(unknown)}"] if unknown else []
