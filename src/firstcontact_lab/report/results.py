"""Results of a study, by dataset (subject), and their file ``results.json``."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, Generic, TypeVar

import msgspec

from firstcontact.core import Record
from firstcontact.core.files import read_regular, write_json
from firstcontact.core.records import ByName, read_record, to_tree

T = TypeVar("T")
K = TypeVar("K", covariant=True)
S = TypeVar("S")

#: Longest results file that is read, bytes.
LONGEST = 1 << 28
FIELDS: dict[str, Field[Any]] = {}


class Field(Generic[K]):
    """Key of ``results.json``, together with the type of the value under this key."""

    def __init__(self, name: str, kind: Any, default: K) -> None:
        self.name, self.kind, self.default = name, kind, default
        FIELDS[name] = self

    @classmethod
    def optional(cls, name: str, kind: type[S]) -> Field[S | None]:
        return Field(name, kind | None, None)

    def __call__(self, value: K) -> Entry:  # type: ignore[misc]
        return self.name, value


Entry = tuple[str, Any]


class SubjectResults(Record, frozen=True, kw_only=True):
    """Results of one dataset under study.

    Read a result with ``results[FIELD]``. Type checkers know its type.
    """

    def __getitem__(self, field: Field[T]) -> T:
        value: T = getattr(self, field.name, field.default)
        return value

    def replace(self, entries: Iterable[Entry]) -> SubjectResults:
        """Return a copy of the results with ``entries`` added or replaced.

        If the old and the new value are mappings, the new value is merged into the old one.
        """
        values = {name: getattr(self, name) for name in self.__struct_fields__}
        for name, value in entries:
            existing = values.get(name)
            if isinstance(value, ByName) and isinstance(existing, ByName):
                value = ByName({**existing, **value}, value.about)
            values[name] = value
        return subject_kind()(**values)


NOTHING = SubjectResults()
_kinds: dict[tuple[str, ...], type[SubjectResults]] = {}


def subject_kind() -> type[SubjectResults]:
    names = tuple(FIELDS)
    if names not in _kinds:
        fields = [(f.name, f.kind, f.default) for f in FIELDS.values()]
        kind: Any = msgspec.defstruct(
            "SubjectResults", fields, bases=(SubjectResults,), frozen=True, kw_only=True
        )
        _kinds[names] = kind
    return _kinds[names]


class _Run(msgspec.Struct):
    options: dict[str, Any] = msgspec.field(name="asked")


class _Options(msgspec.Struct):
    study: _Run


def write_results(path: Path, results: object) -> None:
    write_json(path, to_tree(results))


def read_results(path: Path, kind: type[T]) -> T:
    remedy = "give the results.json of a study of this version"
    return read_record(read_regular(path, LONGEST), kind, str(path), remedy, LONGEST)


def read_options(path: Path, remedy: str) -> dict[str, Any]:
    """Return those settings of a study that affect its numbers, from ``results.json`` at ``path``.

    Raise FileError if the file is not valid. The message ends with ``remedy``.
    """
    return read_record(
        read_regular(path, LONGEST), _Options, str(path), remedy, LONGEST
    ).study.options
