"""``results.json``: written and read here and nowhere else."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar

import msgspec

from firstcontact.core import read_record, read_regular, to_tree, write_json

T = TypeVar("T")

#: No study's results are longer, bytes.
LONGEST = 1 << 28


class _Run(msgspec.Struct):
    asked: dict[str, Any]


class _Asked(msgspec.Struct):
    study: _Run


def write_results(path: Path, results: object) -> None:
    """Write a study's results whole; what is not known is left out."""
    write_json(path, to_tree(results))


def read_results(path: Path, kind: type[T]) -> T:
    """Results of a study, ``StudyResults`` or ``GraspResults``.

    Raises
    ------
    InputError
        A field is missing, unknown, or of another kind.
    """
    remedy = "give the results.json of a study of this version"
    return read_record(read_regular(path, LONGEST), kind, str(path), remedy, LONGEST)


def read_asked(path: Path, remedy: str) -> dict[str, Any]:
    """What the results of any study depend on, of any version that says so.

    Raises
    ------
    InputError
        They do not say it.
    """
    return read_record(read_regular(path, LONGEST), _Asked, str(path), remedy, LONGEST).study.asked
