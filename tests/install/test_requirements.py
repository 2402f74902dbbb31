"""Installed requirements are pinned, hashed and complete."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import sys
import tomllib
import venv
import zipfile
from pathlib import Path

import pip
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


def wheel(folder: Path) -> str:
    """Write an empty wheel. Return its SHA-256."""
    folder.mkdir()
    file = folder / "trinket-1.0-py3-none-any.whl"
    info = "trinket-1.0.dist-info"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("trinket.py", "")
        archive.writestr(f"{info}/METADATA", "Metadata-Version: 2.1\nName: trinket\nVersion: 1.0\n")
        archive.writestr(
            f"{info}/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
        )
        archive.writestr(f"{info}/RECORD", "")
    return hashlib.sha256(file.read_bytes()).hexdigest()


def _environment_with_pip(folder: Path) -> None:
    """Make an environment with the pip of this one, which takes seconds less than its own."""
    venv.create(folder, with_pip=False)
    (site,) = folder.glob("lib/*/site-packages")
    (site / "pip").symlink_to(Path(pip.__file__).parent)
    (folder / "bin" / "pip").touch()


def test_a_package_with_another_hash_is_not_installed(tmp_path: Path) -> None:
    """The Makefile has the same pip options. Here the requirements name one package."""
    shutil.copy(ROOT / "Makefile", tmp_path)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    plugin = Path("examples/plugin_estimators")
    (tmp_path / plugin).mkdir(parents=True)
    shutil.copy(ROOT / plugin / "pyproject.toml", tmp_path / plugin)
    right = wheel(tmp_path / "wheels")
    (tmp_path / "requirements").mkdir()
    entries = [tmp_path / "requirements" / f"{layer}.txt" for layer in ("base", "live")]
    for entry in entries:
        entry.write_text("")
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("PIP_", "MAKE"))} | {
        "PIP_CONFIG_FILE": os.devnull,
        "PIP_NO_INDEX": "1",
        "PIP_FIND_LINKS": str(tmp_path / "wheels"),
    }

    def make() -> subprocess.CompletedProcess[str]:
        command = ["make", "-C", tmp_path, f"PYTHON={sys.executable}", ".venv/.live"]
        return subprocess.run(command, capture_output=True, text=True, env=environment)

    def installed() -> bool:
        return bool(list(tmp_path.glob(".venv/lib/*/site-packages/trinket.py")))

    _environment_with_pip(tmp_path / ".venv")
    refusals = {
        f"trinket==1.0 --hash=sha256:{'0' * 64}\n": "DO NOT MATCH THE HASHES",
        "trinket==1.0\n": "--require-hashes",
    }
    for entry, (line, message) in zip(entries, refusals.items(), strict=True):
        entry.write_text(line)
        process = make()
        assert process.returncode != 0
        assert message in process.stderr
        assert not installed()
        entry.write_text("")
    # The right one is taken; the package behind it is not here to be built.
    entries[0].write_text(f"trinket==1.0 --hash=sha256:{right}\n")
    make()
    assert installed()
