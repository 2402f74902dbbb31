"""JSON objects that hold entries under names of a registry beside fields of their own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Generic, TypeVar, get_args

import msgspec

Each = TypeVar("Each")
About = TypeVar("About")


class Record(
    msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, forbid_unknown_fields=True
):
    """A JSON object of which every field is known; what is None is left out of it.

    A subclass says ``frozen=True, kw_only=True`` again, for type checkers and for msgspec.
    """


class ByName(Mapping[str, Each], Generic[Each, About]):
    """Entries by their names, with a record of what holds for all of them.

    In JSON both stand in one object, so no name may be a field of the record.

    Parameters
    ----------
    entries
        By name, in order.
    about
        A :class:`Record`, whose fields stand before the entries.
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
    """Records, and whatever holds some, as what :func:`json.dumps` takes."""
    return msgspec.to_builtins(value, enc_hook=_joined)


def _joined(value: object) -> dict[str, Any]:
    if not isinstance(value, ByName):
        raise NotImplementedError(f"{type(value).__name__} has no form in JSON")
    return {**to_tree(value.about), **value.entries}


def divided(kind: Any, tree: Any) -> Any:
    """What msgspec asks for the value of a field that is a :class:`ByName`."""
    each, about = get_args(kind)
    named: Any = dict[str, each]  # type: ignore[valid-type]
    if not isinstance(tree, dict):
        raise TypeError(f"Expected `object`, got `{type(tree).__name__}`")
    own = {field.encode_name for field in msgspec.structs.fields(about)}
    entries = {name: its for name, its in tree.items() if name not in own}
    fields = {name: its for name, its in tree.items() if name in own}
    return ByName(
        msgspec.convert(entries, named, dec_hook=divided),
        msgspec.convert(fields, about, dec_hook=divided),
    )
