"""Reader for untrusted JSON, with bounded size and checked types.

All JSON files, messages and descriptors are read here. The types are frozen dataclasses of this
package; ``Annotated`` fields carry their bounds.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Generic, TypeVar, get_args

import msgspec

from firstcontact.core._errors import FileError, InputError

T = TypeVar("T")
Each = TypeVar("Each")
About = TypeVar("About")

#: Default limit on the size of a JSON text, bytes.
LONGEST = 1 << 20

#: Longest name or short text, characters.
LONGEST_NAME = 200
Name = Annotated[str, msgspec.Meta(max_length=LONGEST_NAME)]
#: Free text of the operator.
Notes = Annotated[str, msgspec.Meta(max_length=100_000)]
#: Count or sample number of a device: a signed 64-bit integer, as in its protocol.
Count = Annotated[int, msgspec.Meta(ge=0, le=(1 << 63) - 1)]


def read_record(
    data: bytes,
    kind: type[T],
    origin: str,
    remedy: str,
    longest: int = LONGEST,
    error: type[InputError] = FileError,
) -> T:
    """Parse untrusted JSON as a value of the type ``kind``.

    Raises ``error`` if the data are longer than ``longest`` bytes or do not fit the type. The
    message names the file or sender, ``origin``, and ends with ``remedy``.
    """
    if len(data) > longest:
        raise error(f"{origin} has {len(data)} bytes of JSON, more than {longest}: {remedy}")
    try:
        return msgspec.json.decode(data, type=kind, dec_hook=decode_by_name)
    except msgspec.ValidationError as problem:
        raise error(f"{origin}: {_begin_with_field(str(problem))}: {remedy}") from problem
    except (msgspec.DecodeError, UnicodeDecodeError) as problem:
        raise error(f"{origin} is not JSON in UTF-8: {remedy}") from problem
    except RecursionError as problem:
        raise error(f"{origin} is nested too deeply: {remedy}") from problem


def _begin_with_field(problem: str) -> str:
    """Return an error message of msgspec, reworded so that it begins with the field's name."""
    reason, _, place = problem.rpartition(" - at `")
    if not reason:
        return _cut(problem)
    field = place.removesuffix("`").removeprefix("$").removeprefix(".")
    return f"{field or 'it'} is wrong ({_cut(reason[0].lower() + reason[1:])})"


def _cut(text: str, most: int = 200) -> str:
    """Return ``text``, cut to ``most`` characters: a message may repeat a value of any length."""
    return text if len(text) <= most else f"{text[: most - 1]}…"


class Record(
    msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, forbid_unknown_fields=True
):
    """Base class of records stored as JSON. Unknown fields are errors; default values are omitted.

    A subclass must repeat ``frozen=True, kw_only=True`` for type checkers and msgspec.
    """


class ByName(Mapping[str, Each], Generic[Each, About]):
    """JSON object that maps names to records, beside a few fixed fields.

    ``entries`` are the records by name. ``about`` is a record of the fixed fields, written first.
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
        raise NotImplementedError(
            f"{type(value).__name__} cannot be written as JSON: use a record, a list, a dict, "
            "text or a number"
        )
    return {**to_tree(value.about), **value.entries}


def decode_by_name(kind: Any, tree: Any) -> Any:
    """Convert parsed JSON to a :class:`ByName` of the type ``kind``, as msgspec's ``dec_hook``."""
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
