"""A module that only its own room needs is private: its name begins with an underscore."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SRC = ROOT / "src"
#: These are private as a whole: the command, and folders that one consumer reads file by file.
WHOLE = ("cli", "study/parts", "report/figures", "grasp_study/figures")
#: What people read or run beside the package; decisions and changes are history.
OUTSIDE = ("docs", "examples", "benchmarks", "firmware", "tests/plugins")


def name_of(file: Path) -> str:
    return ".".join(file.relative_to(SRC).with_suffix("").parts)


def room_of(name: str) -> str:
    return name.split(".")[1] if name.count(".") else ""


FILES = sorted((SRC / "firstcontact").rglob("*.py"))
MODULES = {
    name_of(file): file
    for file in FILES
    if file.stem != "__init__"
    and file.parent != SRC / "firstcontact"
    and not file.relative_to(SRC / "firstcontact").as_posix().startswith(WHOLE)
}


def imports(text: str) -> set[str]:
    """What Python code imports, its examples too, and what it may: ``from a import b``."""
    names = set(re.findall(r">>> from ([\w.]+) import", text))
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom):
            names |= {f"{node.module}", *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
    return names


@cache
def of_other_rooms() -> dict[str, set[str]]:
    """The modules of the package that each file imports from rooms other than its own."""
    found = {}
    for file in FILES:
        room = room_of(name_of(file))
        found[name_of(file)] = {n for n in imports(file.read_text()) if room_of(n) != room}
    return found


@cache
def named_outside() -> str:
    """All text in which somebody else may name a module, registries among it."""
    texts = [
        (ROOT / name).read_text() for name in ("README.md", "CONTRIBUTING.md", "pyproject.toml")
    ]
    for folder in OUTSIDE:
        files = (f for f in (ROOT / folder).rglob("*") if f.suffix in (".md", ".py", ".toml"))
        texts += [file.read_text() for file in files]
    for file in FILES:
        text, here = file.read_text(), file.parent.relative_to(SRC).as_posix().replace("/", ".")
        entries = re.findall(r'"([\w.{}]+):\w+"', text) + re.findall(r'_in\("(\w+)"', text)
        texts += [re.sub(r"^(\{_HERE\}\.)?(?!firstcontact)", f"{here}.", e) for e in entries]
        texts += re.findall(r'"(firstcontact\.[\w.]+)"', text)
    return "\n".join(texts)


def is_named(module: str, text: str) -> bool:
    path = module.removeprefix("firstcontact.").replace(".", "/")
    package, _, name = module.rpartition(".")
    forms = (
        rf"\b{re.escape(module)}\b",
        rf"(?<![\w/]){path}\.py\b",
        rf"src/firstcontact/{path}\.py\b",
        rf"from {re.escape(package)} import [^\n]*\b{name}\b",
    )
    return re.search("|".join(forms), text) is not None


@pytest.mark.parametrize("module", MODULES)
def test_it_is_private_where_nobody_else_needs_it(module: str) -> None:
    needed = any(module in names for names in of_other_rooms().values()) or is_named(
        module, named_outside()
    )
    private = MODULES[module].stem.startswith("_")
    assert private or needed, (
        f"only {room_of(module)} needs {module}: call it _{MODULES[module].name}"
    )


def test_no_room_imports_what_another_keeps_to_itself() -> None:
    for file, names in of_other_rooms().items():
        own = [n for n in names if n.startswith("firstcontact.")]
        assert not [n for n in own if any(p.startswith("_") for p in n.split(".")[2:])], file


def test_an_import_and_a_name_are_seen() -> None:
    assert imports("from firstcontact.core import _block as b\nimport os.path") == {
        "firstcontact.core", "firstcontact.core._block", "os.path",
    }  # fmt: skip
    assert is_named("firstcontact.contact.gate", "see `contact/gate.py`")
    assert not is_named("firstcontact.contact.gate", "see `live/contact/gate.py` and `gate.py`")
