"""Plan of a recording: objects, and the number of their pinches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from firstcontact.core import (
    LONGEST_NAME,
    InputError,
    Label,
    Role,
    check_text,
    parse_float,
    parse_int,
)
from firstcontact.recording import quote, read_rows

#: Largest number of pinches of an object in a session.
MOST_PINCHES = 1_000_000
#: Columns of a plan; the first two must be there.
COLUMNS = ("object", "pinches", "shore", "specimen", "role")


@dataclass(frozen=True, slots=True)
class Item:
    """One object of a plan.

    Parameters
    ----------
    object
        Name of the object.
    pinches
        Number of valid pinches wanted in a session.
    shore
        Shore A; None if unknown.
    specimen
        Name of the specimen; the object's name by default.
    role
        Use of the pinches: training or test.
    """

    object: str
    pinches: int
    shore: float | None = None
    specimen: str = ""
    role: Role = Role.TRAIN

    def __post_init__(self) -> None:
        if not self.object:
            raise InputError("the object's name is empty: give a name")
        if max(len(self.object), len(self.specimen)) > LONGEST_NAME:
            raise InputError(
                f"the name of the object or specimen is longer than {LONGEST_NAME} characters: "
                "shorten it"
            )
        for name in (self.object, self.specimen):
            check_text(name)
        if not 1 <= self.pinches <= MOST_PINCHES:
            raise InputError(
                f"{self.object}: the number of pinches is {self.pinches}: give a number from 1 to "
                f"{MOST_PINCHES}"
            )
        if self.shore is not None and not 0 <= self.shore <= 100:
            raise InputError(
                f"{self.object}: the value of shore is {self.shore:g}: give a Shore A from 0 to 100"
            )

    def label(self, session: str) -> Label:
        """Return the label of the object's pinches in a session."""
        specimen = self.specimen or self.object
        return Label(self.object, self.shore, None, specimen, session, self.role)


def read_plan(path: Path) -> tuple[Item, ...]:
    """Read a CSV with the columns object, pinches, shore, specimen and role.

    Raises
    ------
    InputError
        The file cannot be read, misses a column, has an unknown column, is empty, names an object
        twice, or has a value that cannot be used.
    """
    rows = read_rows(path, COLUMNS[:2])
    for name in rows[0][1] if rows else ():
        if name not in COLUMNS:
            raise InputError(
                f"{path}: column {name!r} is not known: the columns are {', '.join(COLUMNS)}"
            )
    items = tuple(_item(path, line, row) for line, row in rows)
    if not items:
        raise InputError(f"{path} has no objects: add a line for each object")
    labels = [item.label("") for item in items]
    for k, label in enumerate(labels):
        if label in labels[:k]:
            raise InputError(
                f"{path}, line {rows[k][0]}: {label.specimen} is listed twice: join the lines"
            )
    return items


def _item(path: Path, line: int, cells: Mapping[str, str]) -> Item:
    field = "pinches"
    try:
        pinches = parse_int(cells["pinches"])
        field = "shore"
        shore = parse_float(cells["shore"]) if cells.get("shore") else None
        field = "role"
        role = Role(cells.get("role") or Role.TRAIN)
    except ValueError as error:
        raise InputError(
            f"{path}, line {line}: {field} is {quote(cells[field])}: give "
            + ("train or test" if field == "role" else "a number")
        ) from error
    try:
        return Item(cells["object"], pinches, shore, cells.get("specimen", ""), role)
    except InputError as error:
        raise InputError(f"{path}, line {line}: {error}") from error
