"""Numbers as C code: literals, arrays, and constant structs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isinf, isnan
from textwrap import fill
from typing import Any

import numpy as np
from numpy.typing import NDArray

_TYPES = {"f4": "float", "f8": "double", "i1": "int8_t", "i2": "int16_t", "i4": "int32_t"}


def c_type(array: NDArray[Any]) -> str:
    """Return the C type of an array's numbers; ValueError if there is none."""
    kind = array.dtype.str[1:]
    if kind not in _TYPES:
        raise ValueError(f"no C type for {array.dtype}")
    return _TYPES[kind]


def literal(value: float | np.generic) -> str:
    """Return the shortest C literal that reads back as the same number."""
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isnan(value) or isinf(value):
        return "NAN" if isnan(value) else "INFINITY" if float(value) > 0 else "-INFINITY"
    text = str(value) if isinstance(value, np.float32) else repr(float(value))
    text = text if any(mark in text for mark in ".e") else text + ".0"
    return text + "f" * isinstance(value, np.float32)


def c_array(name: str, array: NDArray[Any]) -> str:
    """Return the C definition of a constant array that stays in flash memory."""
    numbers = fill(", ".join(map(literal, array.reshape(-1))), 100, break_long_words=False)
    return f"static const {c_type(array)} {name}[{array.size}] FC_FLASH = {{\n{numbers}}};\n"


def c_struct(kind: str, name: str, fields: Mapping[str, int | float | str | NDArray[Any]]) -> str:
    """Return the C definition of a constant struct and its arrays."""
    arrays, members = [], []
    for field, value in fields.items():
        if isinstance(value, np.ndarray):
            arrays.append(c_array(f"{name}_{field}", value))
            members.append(f".{field} = {name}_{field}")
        else:
            members.append(f".{field} = {value if isinstance(value, str) else literal(value)}")
    inside = fill(", ".join(members), 96, initial_indent="    ", subsequent_indent="    ")
    return "".join(arrays) + f"static const {kind} {name} = {{\n{inside}}};\n"


def constant_bytes(fields: Mapping[str, Any]) -> int:
    """Return the total size (bytes) of the arrays among the values of ``fields``."""
    return sum(value.nbytes for value in fields.values() if isinstance(value, np.ndarray))


@dataclass(frozen=True, slots=True)
class CUnit:
    """C header and source that the export generates for one part of a model."""

    name: str
    header: str
    source: str
    constants: int
    memory: int
    instructions: int
    fixed: tuple[str, ...]
    rate: float | None = None
