"""Reading and validation of the table of household objects."""

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

#: Smallest and largest value of each quantity, in SI units and Shore A. A value outside probably
#: has another unit.
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
#: Shore A from which an object counts as firm.
FIRM = 45.0
#: Entry in the column ``year`` for a publication without one.
UNDATED = "undated"


@dataclass(frozen=True, slots=True)
class HouseholdSource:
    """Publication that is the source of a number."""

    key: str
    authors: str
    year: int | None
    """Year of the publication; None if it is undated."""
    title: str
    where: str


def read_sources(text: str, file: str) -> dict[str, HouseholdSource]:
    """Return the sources by their key."""
    by_key: dict[str, HouseholdSource] = {}
    columns = [field.name for field in fields(HouseholdSource)]
    for line, row in _rows(text, file, columns):
        place = f"{file}, line {line}"
        if any(not row[name] for name in columns):
            raise InputError(f"{place}: a field is empty: fill in {', '.join(columns)}")
        if row["key"] in by_key or row["key"] == ESTIMATE:
            raise InputError(f"{place}: another line has the key {row['key']!r}: use another key")
        year = int(row["year"]) if row["year"].isdecimal() else None
        if row["year"] != UNDATED and not (year and 1800 <= year <= 2100):
            raise InputError(
                f"{place}: the year is {row['year']!r}: use four digits or {UNDATED!r}"
            )
        by_key[row["key"]] = HouseholdSource(
            row["key"], row["authors"], year, row["title"], row["where"]
        )
    return by_key


def read_household(
    text: str, sources: Mapping[str, HouseholdSource], file: str
) -> tuple[HouseholdObject, ...]:
    """Return the objects in the order of the file."""
    columns = ["name", "group", "origin"]
    columns += [name for q in QUANTITIES for name in (q, f"{q}_from")]
    by_name: dict[str, HouseholdObject] = {}
    for line, row in _rows(text, file, columns):
        place = f"{file}, line {line}"
        if not row["name"]:
            raise InputError(f"{place}: name is empty: give the object a name")
        if row["name"] in by_name:
            raise InputError(
                f"{place}: another object has the name {row['name']!r}: use another name"
            )
        if row["origin"] not in SCATTER:
            raise InputError(f"{place}: origin is {row['origin']!r}: use {' or '.join(SCATTER)}")
        numbers = {q: _quantity(row, q, sources, place) for q in QUANTITIES}
        _complete(numbers, place)
        one = HouseholdObject(
            row["name"],
            row["group"],
            row["origin"],
            HouseholdNumbers(**numbers),  # type: ignore[arg-type]  # checked by _complete
        )
        if one.group != fitting_group(one.numbers):
            raise InputError(
                f"{place}: the group is {one.group!r}, but the object's numbers fit "
                f"{fitting_group(one.numbers)!r}: use this group, or correct the numbers"
            )
        by_name[one.name] = one
    return tuple(by_name.values())


def fitting_group(numbers: HouseholdNumbers) -> str:
    """Return the group of an object, such as "soft fragile", from its numbers."""
    hardness = "soft" if numbers.shore_a.value < FIRM else "firm"
    return f"{hardness} {'robust' if numbers.limit is None else 'fragile'}"


def _rows(text: str, file: str, columns: list[str]) -> list[tuple[int, dict[str, str]]]:
    reader = csv.DictReader(StringIO(text), strict=True)
    if reader.fieldnames != columns:
        raise InputError(f"{file}, line 1: the columns must be {', '.join(columns)}")
    rows = []
    for row in reader:
        if None in row or None in row.values():
            raise InputError(
                f"{file}, line {reader.line_num}: the row has another number of cells than the "
                f"header: give {len(columns)} cells"
            )
        rows.append((reader.line_num, {name: cell.strip() for name, cell in row.items()}))
    return rows


def _quantity(
    row: Mapping[str, str], name: str, sources: Mapping[str, HouseholdSource], place: str
) -> Quantity | None:
    value, source = row[name], row[f"{name}_from"]
    if not value:
        if source:
            raise InputError(f"{place}: {name} has a source but no value: give it a value")
        if name not in OPTIONAL:
            raise InputError(f"{place}: {name} is empty: give it a value")
        return None
    low, high = RANGES[name]
    try:
        number = float(value)
    except ValueError:
        number = float("nan")
    if not (isfinite(number) and low <= number <= high):
        raise InputError(f"{place}: {name} is {value!r}: use a number from {low:g} to {high:g}")
    if source != ESTIMATE and source not in sources:
        raise InputError(
            f"{place}: the source of {name} is {source!r}, which is not known: use {ESTIMATE!r} or "
            "the key of a source"
        )
    return Quantity(number, source)


def _complete(numbers: Mapping[str, Quantity | None], place: str) -> None:
    if (numbers["limit"] is None) != (numbers["weibull"] is None):
        raise InputError(f"{place}: limit and weibull belong together: give both or none")
    if numbers["bulk"] is None and numbers["radius"] is None:
        raise InputError(f"{place}: bulk and radius are both empty: give one of them")
