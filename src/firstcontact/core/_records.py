"""JSON that comes from outside: of bounded size, and checked against the type that it must have.

Every file, message and descriptor in JSON is read here and nowhere else. The types are the
package's own frozen dataclasses; ``Annotated`` fields carry their bounds.
"""

from __future__ import annotations

from typing import Annotated, TypeVar

import msgspec

from firstcontact.core._errors import InputError
from firstcontact.core._records_json import divided

T = TypeVar("T")

#: Longest JSON that is looked at unless more is asked for, bytes.
LONGEST = 1 << 20

#: Longest name or short text, characters; nobody's object needs more.
LONGEST_NAME = 200
Name = Annotated[str, msgspec.Meta(max_length=LONGEST_NAME)]
#: The operator's words.
Notes = Annotated[str, msgspec.Meta(max_length=100_000)]
#: Counts and sample numbers of a device: 64 bits with the sign, as its protocol has them.
Count = Annotated[int, msgspec.Meta(ge=0, le=(1 << 63) - 1)]


def read_record(data: bytes, kind: type[T], where: str, remedy: str, longest: int = LONGEST) -> T:
    """JSON as a value of a type.

    Parameters
    ----------
    data
        UTF-8.
    kind
        A dataclass, or any type that msgspec knows. Numbers that are not finite
        or outside a field's bounds are refused; fields that it does not have are
        left out, or refused by a :class:`firstcontact.core._records_json.Record`.
    where
        What was read, for the message: a file, or a part of one.
    remedy
        What to do about it, for the message.
    longest
        Most bytes that are looked at.

    Raises
    ------
    InputError
        Too long, no JSON, nested too deeply, or a field that is missing or
        cannot be what it says.
    """
    if len(data) > longest:
        raise InputError(f"{where} has {len(data)} bytes of JSON, more than {longest}: {remedy}")
    try:
        return msgspec.json.decode(data, type=kind, dec_hook=divided)
    except msgspec.ValidationError as error:
        raise InputError(f"{where}: {_sentence(str(error))}: {remedy}") from error
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{where} is not JSON in UTF-8: {remedy}") from error
    except RecursionError as error:
        raise InputError(f"{where} is nested too deeply: {remedy}") from error


def _sentence(problem: str) -> str:
    """Msgspec's "Expected `int`, got `str` - at `$.layout.rate`", field first."""
    what, _, place = problem.rpartition(" - at `")
    if not what:
        return _short(problem)
    field = place.removesuffix("`").removeprefix("$").removeprefix(".")
    return f"{field or 'it'} is wrong ({_short(what[0].lower() + what[1:])})"


def _short(text: str, most: int = 200) -> str:
    """A problem repeats the value that it is about, however long."""
    return text if len(text) <= most else f"{text[: most - 1]}…"
