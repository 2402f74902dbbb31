"""A release: one version, and exactly the declared, pinned and hashed requirements."""

import ast
import re
import sys
import tomllib
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest
import yaml

import firstcontact

ROOT = Path(__file__).parents[2]
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]


def test_the_version_is_that_of_pyproject_and_of_the_newest_changes() -> None:
    assert firstcontact.__version__ == VERSION, "make install"
    changes = (ROOT / "CHANGELOG.md").read_text("utf-8")
    newest = re.search(r"^## (\d+\.\d+\.\d+), (not yet released|\d{4}-\d\d-\d\d)$", changes, re.M)
    assert newest[1] == VERSION


def test_sources_do_not_repeat_the_version() -> None:
    written = "firmware/core/fc_layout.h"  # tests/firmware/test_sketch.py compares its version
    files = [p for room in ("src", "firmware") for p in (ROOT / room).rglob("*.*")]
    files = [p for p in files if p.suffix in {".py", ".pyi", ".c", ".h", ".ino", ".js", ".html"}]
    files = [p for p in files if p != ROOT / written]
    assert [p for p in files if f'"{VERSION}' in p.read_text("utf-8")] == []


def test_the_citation_names_the_paper_that_the_readme_names() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    assert {"cff-version", "message", "title", "authors"} <= citation.keys()
    (paper,) = citation["references"]
    readme = " ".join((ROOT / "README.md").read_text("utf-8").split())
    assert paper["title"] in readme
    assert all(author["family-names"] in readme for author in paper["authors"])


def test_issue_templates_ask_for_the_installation() -> None:
    templates = [*(ROOT / ".github/ISSUE_TEMPLATE").glob("*.md")]
    assert templates
    for template in templates:
        head = template.read_text("utf-8").split("---\n")[1]
        assert {"name", "about"} <= yaml.safe_load(head).keys()
        assert "`firstcontact info`" in template.read_text("utf-8")


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


FOLDER = ROOT / "requirements"
#: What the targets of the Makefile install, and the extras that they promise.
TARGETS = {
    (".study", "base study cuda"): ("study",),
    (".live", "base live"): ("live",),
    (".dev", "base study live dev cuda"): ("dev",),
}


def pins(file: Path) -> dict[str, str]:
    """Return the version of each package. Each must have a hash."""
    text = re.sub(r"\\\n", " ", file.read_text())
    collected = {}
    for line in filter(None, (line.partition("#")[0].strip() for line in text.splitlines())):
        name, version = re.match(r"([\w.-]+)==([\w.+]+)", line).groups()  # type: ignore[union-attr]
        if file.parent == FOLDER:
            assert re.search(r"--hash=sha256:[0-9a-f]{64}", line), f"{file.name}: {name}"
        assert normal(name) not in collected
        collected[normal(name)] = version
    return collected


def dependencies(*extras: str) -> set[str]:
    """Return the names of the package's direct dependencies with these extras."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    names = set()
    lines = list(project["dependencies"])
    for extra in extras:
        lines += project["optional-dependencies"][extra]
    for line in lines:
        name, more = re.match(r"([\w.-]+)(?:\[([\w,]+)\])?", line).groups()  # type: ignore[union-attr]
        names |= dependencies(*more.split(",")) if name == "firstcontact" else {normal(name)}
    return names


def test_hashed_versions_are_those_of_the_constraints() -> None:
    wanted = pins(ROOT / "constraints.txt")
    layers = {file.stem: pins(file) for file in FOLDER.glob("*.txt")}
    assert layers.pop("cpu") == {"torch": f"{wanted['torch']}+cpu"}
    collected: dict[str, str] = {}
    for layer in layers.values():
        assert not collected.keys() & layer.keys(), "a package stands in one file"
        collected |= layer
    assert collected == wanted


@pytest.mark.parametrize(("target", "layers"), TARGETS, ids=lambda v: v if "." in v else "")
def test_what_a_target_promises_is_in_its_files(target: str, layers: str) -> None:
    names = {name for layer in layers.split() for name in pins(FOLDER / f"{layer}.txt")}
    assert dependencies(*TARGETS[target, layers]) <= names
    recipe = (ROOT / "Makefile").read_text().partition(f"$(VENV)/{target}: ")[2].split("\n\n")[0]
    fetched = re.findall(r"(?:fetch|both),([\w ]+)", recipe) + ["cuda"] * ("both," in recipe)
    assert " ".join(fetched) == layers


def test_pip_installs_only_what_has_a_right_hash() -> None:
    """pip refuses a wheel with another hash, or a requirement without one, with this option."""
    (fetch,) = re.findall(r"^fetch += (.*)$", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert {"--require-hashes", "--no-deps", "--only-binary"} <= set(fetch.split())
