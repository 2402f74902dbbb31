"""Modules import downwards, without circles; the names in registries count as imports."""

import re
import sys
import tomllib
from pathlib import Path

import pytest

grimp = pytest.importorskip("grimp")
ROOT = Path(__file__).parents[1]
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]
PACKAGES = SETTINGS["root_packages"]


@pytest.fixture(scope="module")
def graph():
    """Imports of all modules, also those inside functions and for type checkers alone."""
    return grimp.build_graph(*PACKAGES, cache_dir=None)


def circles(graph) -> list[list[str]]:
    """Return the sets of modules that import each other (Tarjan 1972)."""
    number, least, stack, found = {}, {}, [], []

    def visit(module: str) -> None:
        number[module] = least[module] = len(number)
        stack.append(module)
        for other in sorted(graph.find_modules_directly_imported_by(module)):
            if other not in number:
                visit(other)
            if other in stack:
                least[module] = min(least[module], least[other])
        if least[module] == number[module]:
            members = stack[stack.index(module) :]
            del stack[stack.index(module) :]
            if len(members) > 1:
                found.append(sorted(members))

    sys.setrecursionlimit(5_000)
    for module in sorted(graph.modules):
        if module not in number:
            visit(module)
    return found


def test_no_modules_import_each_other(graph):
    assert circles(graph) == []


def test_a_circle_would_be_found():
    graph = grimp.ImportGraph()
    for importer, imported in (("a", "b"), ("b", "c"), ("c", "b"), ("c", "d")):
        graph.add_module(importer)
        graph.add_module(imported)
        graph.add_import(importer=importer, imported=imported)
    assert circles(graph) == [["b", "c"]]


def rooms() -> dict[str, int]:
    """Return the number of each room's layer, the lowest first."""
    [contract] = [c for c in SETTINGS["contracts"] if c["type"] == "layers"]
    layers = reversed(contract["layers"])
    return {room: k for k, layer in enumerate(layers) for room in re.split(r"[ |]+", layer)}


def named_imports() -> list[tuple[str, str]]:
    """Return the pairs of a file's room and a room that it names in a string."""
    folder = ROOT / "src" / "firstcontact"
    pairs = []
    for path in sorted(folder.rglob("*.py")):
        own = path.relative_to(folder).parts[0].removesuffix(".py")
        for other in re.findall(r"[\"']firstcontact\.(\w+)[\w.]*(?::\w+)?[\"']", path.read_text()):
            pairs.append((own, other))
    return pairs


def test_names_in_strings_point_downwards():
    numbers, pairs = rooms(), named_imports()
    named = [(own, other) for own, other in pairs if own in numbers and other in numbers]
    assert ("models", "models") in named
    assert [(own, other) for own, other in named if numbers[other] > numbers[own]] == []
