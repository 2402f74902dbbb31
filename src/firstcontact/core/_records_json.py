"""JSON objects that hold entries with arbitrary names beside fixed fields."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Generic, TypeVar, get_args

import msgspec

Each = TypeVar("Each")
About = TypeVar("About")


class Record(
    msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, forbid_unknown_fields=True
):
    """JSON object with declared fields only. Fields that have their default value are not written.

    A subclass must repeat ``frozen=True, kw_only=True`` for type checkers and msgspec.
    """


class ByName(Mapping[str, Each], Generic[Each, About]):
    """Mapping from names to entries, together with a record of fixed fields.

    JSON stores both in one object, so no entry may have the name of a field.

    Parameters
    ----------
    entries
        Entries by name, in order.
    about
        A :class:`Record` with the fixed fields. In JSON they precede the entries.
    """

    __slots__ = ("about", "entries")

    def __init__(self, entries: Mapping[str, Each], about: About) -> None:
        self.entries, self.about = entries, about

    def __getitem__(self, name: str) -> Each:
        return self.entries[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.entries)

    def __len__(self) -> int:
        return len(self.entries)


def to_tree(value: Any) -> Any:
    """Convert records, and containers of records, to a tree for :func:`json.dumps`."""
    return msgspec.to_builtins(value, enc_hook=_encode_by_name)


def _encode_by_name(value: object) -> dict[str, Any]:
    if not isinstance(value, ByName):
        raise NotImplementedError(f"{type(value).__name__} cannot be written as JSON")
    return {**to_tree(value.about), **value.entries}


def decode_by_name(kind: Any, tree: Any) -> Any:
    """Decode a :class:`ByName` field for msgspec."""
    entry, about = get_args(kind)
    entry_type: Any = dict[str, entry]  # type: ignore[valid-type]
    if not isinstance(tree, dict):
        raise TypeError(f"Expected `object`, got `{type(tree).__name__}`")
    field_names = {field.encode_name for field in msgspec.structs.fields(about)}
    entries = {name: value for name, value in tree.items() if name not in field_names}
    fields = {name: value for name, value in tree.items() if name in field_names}
    return ByName(
        msgspec.convert(entries, entry_type, dec_hook=decode_by_name),
        msgspec.convert(fields, about, dec_hook=decode_by_name),
    )
