"""Reads and checks the table of the household."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass, fields
from io import StringIO
from math import isfinite

from firstcontact.core import InputError
from firstcontact.twin._household_object import (
    ESTIMATE,
    OPTIONAL,
    QUANTITIES,
    SCATTER,
    HouseholdNumbers,
    HouseholdObject,
    Quantity,
)

#: Least and most that a value may be: what is outside is in another unit. SI, and Shore A.
RANGES = {
    "shore_a": (1.0, 98.0),
    "mass": (1e-4, 2.0),
    "friction": (0.05, 1.5),
    "limit": (0.1, 100.0),
    "weibull": (1.0, 50.0),
    "radius": (1e-3, 0.2),
    "thickness": (1e-4, 0.2),
    "bulk": (100.0, 1e7),
    "loss": (0.0, 1.0),
}
#: What is as hard or harder is firm, Shore A.
FIRM = 45.0
#: In place of a year.
UNDATED = "undated"


@dataclass(frozen=True, slots=True)
class HouseholdSource:
    """Whom a number is from, and where it stands."""

    key: str
    authors: str
    year: int | None
    """None where it says none."""
    title: str
    where: str


def read_sources(text: str, file: str) -> dict[str, HouseholdSource]:
    """The sources by their key.

    Raises
    ------
    InputError
        A key twice or one called "estimate", an empty field, a year that is none.
    """
    found: dict[str, HouseholdSource] = {}
    columns = [field.name for field in fields(HouseholdSource)]
    for line, row in _rows(text, file, columns):
        where = f"{file}, line {line}"
        if any(not row[name] for name in columns):
            raise InputError(f"{where}: a field is empty: fill in {', '.join(columns)}")
        if row["key"] in found or row["key"] == ESTIMATE:
            raise InputError(f"{where}: the key {row['key']!r} is taken: use another")
        year = int(row["year"]) if row["year"].isdecimal() else None
        if row["year"] != UNDATED and not (year and 1800 <= year <= 2100):
            raise InputError(f"{where}: {row['year']!r} is no year: use four digits or {UNDATED!r}")
        found[row["key"]] = HouseholdSource(
            row["key"], row["authors"], year, row["title"], row["where"]
        )
    return found


def read_household(
    text: str, sources: Mapping[str, HouseholdSource], file: str
) -> tuple[HouseholdObject, ...]:
    """The objects in the order of the file.

    Parameters
    ----------
    text
        A CSV with name, group, origin and, for each quantity, its value and its source.
    sources
        What sources there are.
    file
        What the file is called.

    Raises
    ------
    InputError
        A column that lacks, a name twice, a value that is none or out of its range, one
        without a source or with an unknown one, a group that does not fit.
    """
    columns = ["name", "group", "origin"]
    columns += [name for q in QUANTITIES for name in (q, f"{q}_from")]
    found: dict[str, HouseholdObject] = {}
    for line, row in _rows(text, file, columns):
        where = f"{file}, line {line}"
        if not row["name"]:
            raise InputError(f"{where}: name is empty: give the object one")
        if row["name"] in found:
            raise InputError(f"{where}: there is a {row['name']!r} already: use another name")
        if row["origin"] not in SCATTER:
            raise InputError(f"{where}: origin is {row['origin']!r}: use {' or '.join(SCATTER)}")
        numbers = {q: _quantity(row, q, sources, where) for q in QUANTITIES}
        _complete(numbers, where)
        one = HouseholdObject(
            row["name"],
            row["group"],
            row["origin"],
            HouseholdNumbers(**numbers),  # type: ignore[arg-type]  # _complete has seen to it
        )
        if one.group != fitting_group(one.numbers):
            raise InputError(
                f"{where}: group is {one.group!r}: its numbers say {fitting_group(one.numbers)!r}"
            )
        found[one.name] = one
    return tuple(found.values())


def fitting_group(numbers: HouseholdNumbers) -> str:
    """The group that the numbers speak for."""
    hardness = "soft" if numbers.shore_a.value < FIRM else "firm"
    return f"{hardness} {'robust' if numbers.limit is None else 'fragile'}"


def _rows(text: str, file: str, columns: list[str]) -> list[tuple[int, dict[str, str]]]:
    reader = csv.DictReader(StringIO(text), strict=True)
    if reader.fieldnames != columns:
        raise InputError(f"{file}, line 1: the columns are not {', '.join(columns)}: use those")
    rows = []
    for row in reader:
        if None in row or None in row.values():
            raise InputError(f"{file}, line {reader.line_num}: use {len(columns)} cells")
        rows.append((reader.line_num, {name: cell.strip() for name, cell in row.items()}))
    return rows


def _quantity(
    row: Mapping[str, str], name: str, sources: Mapping[str, HouseholdSource], where: str
) -> Quantity | None:
    value, source = row[name], row[f"{name}_from"]
    if not value:
        if source:
            raise InputError(f"{where}: {name} has a source and no value: give it one")
        if name not in OPTIONAL:
            raise InputError(f"{where}: {name} is empty: give it a value")
        return None
    low, high = RANGES[name]
    try:
        number = float(value)
    except ValueError:
        number = float("nan")
    if not (isfinite(number) and low <= number <= high):
        raise InputError(f"{where}: {name} is {value!r}: use a number from {low:g} to {high:g}")
    if source != ESTIMATE and source not in sources:
        raise InputError(
            f"{where}: {name} is from {source!r}: use {ESTIMATE!r} or the key of a source"
        )
    return Quantity(number, source)


def _complete(numbers: Mapping[str, Quantity | None], where: str) -> None:
    if (numbers["limit"] is None) != (numbers["weibull"] is None):
        raise InputError(f"{where}: limit and weibull belong together: give both or none")
    if numbers["bulk"] is None and numbers["radius"] is None:
        raise InputError(f"{where}: bulk is empty and radius is, too: give one of them")
