"""Extras are named with their install command. Compiled functions and ONNX Runtime are checked."""

import os
import shlex
import subprocess
import sys
import tomllib
from contextlib import nullcontext
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from types import ModuleType

import pytest

from compiled_kernels import compiled_kernels
from firstcontact.core import InputError, installation
from firstcontact.core.installation import install_command, require_extra
from firstcontact.export import MODEL_EXPORTERS
from firstcontact.models import ESTIMATORS
from firstcontact.recording import EXPORTERS, IMPORTERS

PROJECT = Path(__file__).parents[2] / "pyproject.toml"


@dataclass(frozen=True)
class Entry:
    extra: str = "files"
    modules: tuple[str, ...] = ("numpy", "no_such_module")


def test_missing_extra_is_named_with_its_install_command():
    require_extra(Entry(modules=()))
    require_extra(Entry(modules=("numpy",)))
    with pytest.raises(InputError, match="no_such_module") as refused:
        require_extra(Entry())
    assert install_command("files") in str(refused.value)
    assert "numpy" not in str(refused.value)


@pytest.mark.parametrize(
    "registry", [IMPORTERS, EXPORTERS, MODEL_EXPORTERS, ESTIMATORS], ids=lambda r: r.kind
)
def test_entries_name_extras_that_exist(registry):
    assert isinstance(registry, type(IMPORTERS))
    extras = tomllib.loads(PROJECT.read_text())["project"]["optional-dependencies"]
    for name, entry in registry.items():
        assert bool(entry.extra) == bool(entry.modules), name
        assert entry.extra in {"", *extras}, name


def test_install_command_names_the_path_of_a_clone():
    words = shlex.split(install_command("plot"))
    assert words[-3:] == ["install", "-e", f"{PROJECT.parent}[plot]"]


def test_install_command_of_a_copy_names_a_clone(tmp_path, monkeypatch):
    monkeypatch.setattr(installation, "CLONE", tmp_path)
    assert "'.[plot]'" in install_command("plot")


BLOCKED = """
import sys
for room in ("chain", "device", "twin"):
    sys.modules[f"firstcontact.{room}._compiled"] = None
from firstcontact.cli.main import main
sys.exit(main([sys.argv[1], "--out", "out"]))
"""


@pytest.mark.parametrize("verb", ["simulate", "adapt"])
def test_without_them_one_sentence_names_the_packages_to_install(tmp_path, verb):
    command = [sys.executable, "-c", BLOCKED, verb]
    process = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert process.returncode == 2
    assert process.stderr.count("\n") == 1
    assert all(name in process.stderr for name in ("gcc", "libc6-dev", "python3-dev"))
    assert process.stderr.startswith("firstcontact: the compiled functions")
    assert process.stderr.count(": ") == 3  # no remedy of a file around it
    assert not list(tmp_path.iterdir())


CHECKOUT = """
[[tool.setuptools.ext-modules]]
name = "package._compiled"
sources = ["a.c"]
depends = ["a.h"]
"""


@pytest.mark.parametrize(
    ("in_checkout", "source", "is_used"),
    [(True, b"a", True), (True, b"other", False), (False, b"other", True)],
)
def test_only_a_checkout_refuses_a_module_of_other_sources(
    in_checkout, source, is_used, tmp_path, monkeypatch
):
    (tmp_path / "src/package").mkdir(parents=True)
    binary = tmp_path / "src/package/_compiled.so"
    binary.write_bytes(b"code" + sha256(b"ab").hexdigest().encode())
    (tmp_path / "a.c").write_bytes(source)
    (tmp_path / "a.h").write_bytes(b"b")
    # Times say the opposite.
    os.utime(tmp_path / "a.c", (0, 0) if source != b"a" else None)
    os.utime(binary, (1, 1))
    if in_checkout:
        (tmp_path / "pyproject.toml").write_text(CHECKOUT)
    monkeypatch.setattr(installation, "CLONE", tmp_path)
    module = ModuleType("_compiled")
    module.__file__ = str(binary)
    monkeypatch.setitem(sys.modules, "package._compiled", module)
    load = installation.load_compiled.__wrapped__  # the cached function
    with nullcontext() if is_used else pytest.raises(InputError, match="sources"):
        assert load("package._compiled") is module


def test_the_sources_compile_without_warnings():
    assert compiled_kernels().integrate_all is not None
