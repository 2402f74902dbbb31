"""Reader for untrusted JSON, with bounded size and checked types.

All JSON files, messages and descriptors are read here. The types are frozen dataclasses of this
package; ``Annotated`` fields carry their bounds.
"""

from __future__ import annotations

from typing import Annotated, TypeVar

import msgspec

from firstcontact.core._errors import InputError
from firstcontact.core._records_json import decode_by_name

T = TypeVar("T")

#: Default limit on the size of a JSON text, bytes.
LONGEST = 1 << 20

#: Longest name or short text, characters.
LONGEST_NAME = 200
Name = Annotated[str, msgspec.Meta(max_length=LONGEST_NAME)]
#: Free text of the operator.
Notes = Annotated[str, msgspec.Meta(max_length=100_000)]
#: Count or sample number of a device: a signed 64-bit integer, as in its protocol.
Count = Annotated[int, msgspec.Meta(ge=0, le=(1 << 63) - 1)]


def read_record(data: bytes, kind: type[T], origin: str, remedy: str, longest: int = LONGEST) -> T:
    """Parse JSON into a value of a type.

    Parameters
    ----------
    data
        JSON text in UTF-8.
    kind
        A dataclass, or any type that msgspec supports. Numbers that are not finite or out of
        bounds are refused. Unknown fields are ignored, except in a
        :class:`firstcontact.core._records_json.Record`, which refuses them.
    origin
        Name of the file, or of the part of a file that ``data`` holds, for messages.
    remedy
        Remedy to state in messages.
    longest
        Largest number of bytes to read.

    Raises
    ------
    InputError
        The text is too long, is not JSON, is nested too deeply, or has a field that is missing
        or has a wrong value.
    """
    if len(data) > longest:
        raise InputError(f"{origin} has {len(data)} bytes of JSON, more than {longest}: {remedy}")
    try:
        return msgspec.json.decode(data, type=kind, dec_hook=decode_by_name)
    except msgspec.ValidationError as error:
        raise InputError(f"{origin}: {_sentence(str(error))}: {remedy}") from error
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{origin} is not JSON in UTF-8: {remedy}") from error
    except RecursionError as error:
        raise InputError(f"{origin} is nested too deeply: {remedy}") from error


def _sentence(problem: str) -> str:
    """Return "Expected `int`, got `str` - at `$.layout.rate`" reworded, with the field first."""
    reason, _, place = problem.rpartition(" - at `")
    if not reason:
        return _short(problem)
    field = place.removesuffix("`").removeprefix("$").removeprefix(".")
    return f"{field or 'it'} is wrong ({_short(reason[0].lower() + reason[1:])})"


def _short(text: str, most: int = 200) -> str:
    """Return a message cut to ``most`` characters, because it may repeat a value of any length."""
    return text if len(text) <= most else f"{text[: most - 1]}…"
