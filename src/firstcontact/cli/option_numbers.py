"""Parsers of numbers in options, the same as in files."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from tyro.constructors import ConstructorRegistry, PrimitiveConstructorSpec, PrimitiveTypeInfo

from firstcontact.core import parse_float, parse_int


def option_numbers() -> ConstructorRegistry:
    """Return the rules by which tyro parses options that take a number."""
    registry = ConstructorRegistry()
    registry.primitive_rule(_number)
    return registry


def _number(info: PrimitiveTypeInfo) -> PrimitiveConstructorSpec[float] | None:
    if info.type is float:  # a speed may be infinite
        return _spec("FLOAT", partial(parse_float, finite=False), (int, float))
    return _spec("INT", parse_int, (int,)) if info.type is int else None


def _spec(
    metavar: str, parse: Callable[[str], float], kinds: tuple[type, ...]
) -> PrimitiveConstructorSpec[float]:
    def instance(words: list[str]) -> float:
        try:
            return parse(words[0])
        except ValueError as error:
            raise ValueError(f"{words[0]!r}, {error}") from None

    return PrimitiveConstructorSpec(
        nargs=1,
        metavar=metavar,
        instance_from_str=instance,
        is_instance=lambda value: isinstance(value, kinds),
        str_from_instance=lambda value: [str(value)],
    )
