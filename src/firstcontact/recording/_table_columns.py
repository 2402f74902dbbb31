"""Checks of a table's columns as a whole: the source that they state, and unknown columns."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from difflib import get_close_matches
from pathlib import Path

from firstcontact.core import InputError
from firstcontact.recording._checks import check_source
from firstcontact.recording._labels import CONTACT_COLUMNS, LABEL_COLUMNS
from firstcontact.recording._quoting import listed, quote

#: Smallest similarity, from 0 to 1, of two names of which one is taken for a misspelling.
_ALIKE = 0.75


def stated_source(table: Path, columns: Mapping[str, list[str]]) -> str:
    """Return the source that a table states; "unknown" if it states none."""
    sources = sorted(set(columns.get("source", ["unknown"])))
    if len(sources) > 1:
        raise InputError(
            f"{table}: the column 'source' must be the same in all rows: import each source "
            "separately"
        )
    return check_source(str(table), sources[0])


def unknown_columns(
    table: Path, columns: Collection[str], names: Collection[str], noun: str = "columns"
) -> list[str]:
    """Return a note that lists the unknown columns, if any, and asks about misspelt labels."""
    unknown = sorted(set(columns) - set(names))
    labels = (*LABEL_COLUMNS, *CONTACT_COLUMNS)
    close = {name: get_close_matches(name.lower(), labels, 1, _ALIKE) for name in unknown}
    questions = [
        f"did you mean {match} where it says {quote(name)}?"
        for name, matches in close.items()
        for match in matches
        if match not in columns
    ]
    if not unknown:
        return []
    sentence = f"{table.name}: unknown {noun} were left out: {listed(unknown)}"
    return ["; ".join([sentence, *questions])]
