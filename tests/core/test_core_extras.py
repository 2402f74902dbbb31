"""One check names the missing optional packages of an entry."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

import pytest

from firstcontact.core import InputError, install_command, require_extra
from firstcontact.export import MODEL_EXPORTERS
from firstcontact.models import ESTIMATORS
from firstcontact.recording import EXPORTERS, IMPORTERS

PROJECT = Path(__file__).parents[2] / "pyproject.toml"


@dataclass(frozen=True)
class Entry:
    extra: str = "files"
    modules: tuple[str, ...] = ("numpy", "no_such_module")


def test_missing_extra_is_named_with_its_install_command() -> None:
    require_extra(Entry(modules=()))
    require_extra(Entry(modules=("numpy",)))
    with pytest.raises(InputError, match="no_such_module") as refused:
        require_extra(Entry())
    assert install_command("files") in str(refused.value)
    assert "numpy" not in str(refused.value)


@pytest.mark.parametrize(
    "registry", [IMPORTERS, EXPORTERS, MODEL_EXPORTERS, ESTIMATORS], ids=lambda r: r.kind
)
def test_entries_name_extras_that_exist(registry: object) -> None:
    assert isinstance(registry, type(IMPORTERS))
    extras = tomllib.loads(PROJECT.read_text())["project"]["optional-dependencies"]
    for name, entry in registry.items():
        assert bool(entry.extra) == bool(entry.modules), name
        assert entry.extra in {"", *extras}, name


METADATA = """\
Metadata-Version: 2.4
Name: firstcontact
Version: 0.1.0
Requires-Dist: numpy>=2.0
Requires-Dist: matplotlib>=3.9; extra == "plot"
Requires-Dist: torch>=2.6; extra == "cnn"
Requires-Dist: firstcontact[cnn,plot]; extra == "study"
Requires-Dist: jinja2>=3.1; extra == "study"
Requires-Dist: firstcontact[study]; extra == "dev"
Requires-Dist: pytest>=8; extra == "dev"
"""


def install_words(site: Path, origin: str | None, extra: str) -> list[str]:
    """Return the install command that a copy of the package in ``site`` prints."""
    record = site / "firstcontact-0.1.0.dist-info"
    record.mkdir(parents=True)
    (record / "METADATA").write_text(METADATA)
    if origin is not None:
        (record / "direct_url.json").write_text(json.dumps({"url": origin, "archive_info": {}}))
    (site / "firstcontact").symlink_to(PROJECT.parent / "src" / "firstcontact")
    script = f"from firstcontact.core._extras import *; print(install_command({extra!r}))"
    result = subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, "PYTHONPATH": str(site)},
        capture_output=True,
        text=True,
        check=True,
    )
    return shlex.split(result.stdout)


def test_install_command_names_the_path_of_a_clone() -> None:
    *words, target = shlex.split(install_command("plot"))
    assert words[-3:] == ["pip", "install", "-e"]
    assert target == f"{PROJECT.parent}[plot]"


def test_install_command_names_the_path_of_a_wheel(tmp_path: Path) -> None:
    wheel = tmp_path / "our wheels" / "firstcontact-0.1.0-py3-none-any.whl"
    wheel.parent.mkdir()
    wheel.touch()
    words = install_words(tmp_path / "site", wheel.as_uri(), "plot")
    assert words[-3:] == ["pip", "install", f"{wheel}[plot]"]


@pytest.mark.parametrize("origin", [None, "file:///gone/firstcontact.whl", "https://a.b/c.whl"])
def test_install_command_without_a_path_names_the_packages(
    tmp_path: Path, origin: str | None
) -> None:
    words = install_words(tmp_path / "site", origin, "study")
    assert words[-4:] == ["install", "torch>=2.6", "matplotlib>=3.9", "jinja2>=3.1"]


def test_docs_install_only_from_a_path() -> None:
    pages = [PROJECT.parent / "README.md", *PROJECT.parent.glob("docs/**/*.md")]
    for path in (*pages, *PROJECT.parent.glob("src/**/*.py")):
        assert not re.search(r"install \W*firstcontact", path.read_text(encoding="utf-8")), path
