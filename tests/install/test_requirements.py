"""Installed requirements are pinned, hashed and complete."""

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "requirements"
#: What the targets of the Makefile install, and the extras that they promise.
TARGETS = {
    (".study", "base study cuda"): ("study",),
    (".live", "base live"): ("live",),
    (".dev", "base study live dev cuda"): ("dev",),
}


def normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


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
