"""Reader and writer of KiCad's S-expressions, as nested lists."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

#: Element: a list, a word without quotes, a text in quotes, or a number.
Element = Any
_TOKEN = re.compile(r'"(?:\\.|[^"\\])*"|[()]|[^\s()"]+')


class Word(str):
    """Word without quotes, such as a keyword."""

    __slots__ = ()


def parse(text: str) -> list[Element]:
    """Return the single S-expression in a text. Unquoted words and numbers become :class:`Word`."""
    stack: list[list[Element]] = [[]]
    for token in _TOKEN.findall(text):
        if token == "(":
            stack.append([])
        elif token == ")":
            finished = stack.pop()
            stack[-1].append(finished)
        elif token.startswith('"'):
            stack[-1].append(re.sub(r"\\(.)", r"\1", token[1:-1]))
        else:
            stack[-1].append(Word(token))
    if len(stack) != 1 or len(stack[0]) != 1:
        raise ValueError("the text is not one complete expression")
    return list(stack[0][0])


def write(element: Element, depth: int = 0) -> str:
    """Return an S-expression as text. Lists of lists are split into lines."""
    if isinstance(element, Word):
        return str(element)
    if isinstance(element, str):
        return '"' + element.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(element, float):
        return f"{element:.4f}".rstrip("0").rstrip(".")
    if isinstance(element, int):
        return str(element)
    is_long = any(
        isinstance(part, list) and any(isinstance(p, list) for p in part) for part in element
    )
    inner = [write(part, depth + 1) for part in element]
    if not is_long:
        return "(" + " ".join(inner) + ")"
    indent = "\n" + "\t" * (depth + 1)
    return "(" + inner[0] + "".join(
        (indent if isinstance(part, list) else " ") + text
        for part, text in zip(element[1:], inner[1:], strict=True)
    ) + "\n" + "\t" * depth + ")"  # fmt: skip


def all_of(element: list[Element], name: str) -> Iterator[list[Element]]:
    """Yield the direct sublists of a list that begin with ``name``."""
    for part in element:
        if isinstance(part, list) and part and part[0] == name:
            yield part


def one_of(element: list[Element], name: str) -> list[Element]:
    """Return the first direct sublist of a list that begins with ``name``.

    Raises
    ------
    KeyError
        There is none.
    """
    for part in all_of(element, name):
        return part
    raise KeyError(name)


def numbers(element: list[Element]) -> list[float]:
    """Return the numbers in a list such as ``(at 1 2)``."""
    return [float(part) for part in element[1:] if re.fullmatch(r"-?[\d.]+(e-?\d+)?", str(part))]


def property_of(element: list[Element], name: str) -> str:
    """Return a property of a symbol or footprint by name; "" without it."""
    return next((str(p[2]) for p in all_of(element, "property") if p[1] == name), "")
