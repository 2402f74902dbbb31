"""Tests use what users use: few reach private names, and none sleeps."""

import ast
from collections.abc import Iterator
from pathlib import Path

TESTS = Path(__file__).parents[1]
#: Most private accesses in all tests together. Lower it when you remove some.
MOST = 43
#: Methods of named tuples, and the exit that Python documents.
DOCUMENTED = {"_asdict", "_fields", "_make", "_replace", "_exit"}
#: Call in the text of a program. Not written out, as it would find itself.
SLEEP = "sleep(".join(["time.", ""])
#: Functions whose strings name an attribute.
BY_NAME = {"getattr", "setattr", "delattr", "hasattr"}


def is_private(dotted: str) -> bool:
    """Return True if a part of a dotted name begins, and does not end, with an underscore."""
    parts = dotted.split(".")
    return any(p.startswith("_") and not p.endswith("_") and p not in DOCUMENTED for p in parts)


def private_accesses(tree: ast.AST) -> Iterator[ast.AST]:
    """Find imports, attributes of other objects, and patched names that are private."""
    for node in ast.walk(tree):
        match node:
            case ast.ImportFrom(module=module, names=names):
                found = any(is_private(f"{module}.{alias.name}") for alias in names)
            case ast.Import(names=names):
                found = any(is_private(alias.name) for alias in names)
            case ast.Attribute(value=ast.Name(id="self" | "cls")):
                found = False
            case ast.Attribute(attr=attribute):
                found = is_private(attribute)
            case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name), args=args):
                texts = [arg.value for arg in args if isinstance(arg, ast.Constant)]
                names = [text for text in texts[:2] if isinstance(text, str)]
                found = name in BY_NAME and any(map(is_private, names))
            case _:
                found = False
        if found:
            yield node


def sleeps(tree: ast.AST) -> Iterator[ast.AST]:
    """Find calls of time.sleep, also in programs that a test keeps as text."""
    for node in ast.walk(tree):
        match node:
            case ast.Call(func=ast.Attribute(value=ast.Name(id="time"), attr="sleep")):
                yield node
            case ast.Constant(value=str(text)) if SLEEP in text:
                yield node
            case ast.ImportFrom(module="time", names=names):
                if any(alias.name == "sleep" for alias in names):
                    yield node


def places(find: object, *, without: tuple[str, ...] = ()) -> list[str]:
    """Return file and line of what a function finds in the trees of all tests."""
    return [
        f"{path.relative_to(TESTS)}:{node.lineno} {ast.unparse(node)[:90]}"
        for path in sorted(TESTS.rglob("*.py"))
        if path.relative_to(TESTS).parts[0] not in without
        for node in find(ast.parse(path.read_text(encoding="utf-8")))
    ]


def test_few_tests_reach_private_names() -> None:
    accesses = places(private_accesses)
    assert len(accesses) <= MOST, "\n".join(accesses)


def test_no_test_sleeps_outside_the_soak() -> None:
    assert places(sleeps, without=("soak",)) == []


def test_each_kind_of_access_counts() -> None:
    code = f"""
from firstcontact.room._module import name
from firstcontact.room import _module
import firstcontact.room._module
source._thread.join()
monkeypatch.setattr("firstcontact.room._module.NAME", 1)
monkeypatch.setattr(module, "_name", 1)
self._own, row._replace(x=1), pinch._repr_html_(), os._exit(0)
time.{"sleep"}(1)
"""
    tree = ast.parse(code)
    assert sorted(node.lineno for node in private_accesses(tree)) == [2, 3, 4, 5, 6, 7]
    assert [node.lineno for node in sleeps(tree)] == [9]
