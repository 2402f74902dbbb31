"""The faces of rooms are small, and no import reaches a private module of another room."""

import ast
import re
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SRC = ROOT / "src"
#: Most names in one face, and in all of them.
MOST, MOST_TOGETHER = 25, 150
ROOMS = sorted(
    path.name for path in (SRC / "firstcontact").iterdir() if (path / "__init__.py").is_file()
)
#: Files that show how the package is used: they import what everybody may.
SHOWN = [
    *(ROOT / "examples").rglob("*.py"),
    *(ROOT / "docs").rglob("*.md"),
    *(ROOT / "docs").rglob("*.py"),
    *(ROOT / "benchmarks").rglob("*.py"),
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
]


def imported(text: str) -> set[str]:
    """Return the modules that Python code imports from, as dotted names."""
    names = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
    return names


def is_private(name: str) -> bool:
    return any(part.startswith("_") and not part.endswith("__") for part in name.split("."))


@pytest.mark.parametrize("room", ROOMS)
def test_every_exported_name_exists(room: str) -> None:
    face = import_module(f"firstcontact.{room}")
    assert face.__all__
    for name in face.__all__:
        assert getattr(face, name) is not None


def test_faces_are_small() -> None:
    faces = {room: import_module(f"firstcontact.{room}").__all__ for room in ROOMS}
    counts = {
        room: sum(not name.endswith("Error") for name in names) for room, names in faces.items()
    }
    assert max(counts.values()) <= MOST, counts
    assert sum(counts.values()) <= MOST_TOGETHER, counts


@pytest.mark.parametrize("package", ["firstcontact", "firstcontact_lab"])
def test_no_room_imports_a_private_module_of_another(package: str) -> None:
    for file in sorted((SRC / package).rglob("*.py")):
        parts = file.relative_to(SRC).parts
        own_values = ".".join(parts[:2]) if len(parts) > 2 else parts[0]
        for name in imported(file.read_text()):
            foreign = name.startswith("firstcontact") and not name.startswith(f"{own_values}.")
            module = name.rpartition(".")[0] if name.split(".")[-1].isupper() else name
            assert not (foreign and is_private(module)), f"{file}: {name}"


@pytest.mark.parametrize("file", SHOWN, ids=lambda f: f.relative_to(ROOT).as_posix())
def test_what_is_shown_to_others_imports_no_private_module(file: Path) -> None:
    for name in re.findall(r"(?:from|import) (firstcontact(?:\.\w+)+)", file.read_text()):
        assert not is_private(name), name
