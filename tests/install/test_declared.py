"""The package imports exactly its declared dependencies."""

import ast
import re
import sys
import tomllib
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

ROOT = Path(__file__).parents[2]
#: Extras that users install; ``dev`` may hold more than the package imports.
FOR_USERS = (
    "plot",
    "cnn",
    "train",
    "parquet",
    "study",
    "files",
    "live",
    "foxglove",
    "notebook",
    "audio",
    "hand",
    "cluster",
)


def normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


@cache
def imported() -> dict[str, Path]:
    """Return each package that is imported in ``src``, with a file that imports it."""
    modules: dict[str, Path] = {}
    for file in sorted((ROOT / "src").rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Import):
                modules |= {alias.name.partition(".")[0]: file for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                modules[node.module.partition(".")[0]] = file
    return modules


def declared() -> set[str]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    lines = list(project["dependencies"])
    for extra in FOR_USERS:
        lines += project["optional-dependencies"][extra]
    return {normal(match.group()) for line in lines if (match := re.match(r"[\w.-]+", line))}


def test_every_module_that_is_imported_is_declared() -> None:
    of_module = packages_distributions()
    declared_names = declared()
    missing = set()
    for module, file in imported().items():
        if module in sys.stdlib_module_names or module == "firstcontact":
            continue
        assert module in of_module, f"{file.relative_to(ROOT)} imports {module}: run make install"
        if not {normal(name) for name in of_module[module]} & declared_names:
            missing.add(f"{module} in {file.relative_to(ROOT)}")
    assert not missing
