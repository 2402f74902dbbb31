"""What an entry needs beside the base install is named, by one check."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path

import pytest

from firstcontact.core import InputError
from firstcontact.core.extras import need_for
from firstcontact.embedded.exporters import MODEL_EXPORTERS
from firstcontact.recording.formats import EXPORTERS, IMPORTERS
from firstcontact.stiffness.registry import ESTIMATORS

PROJECT = Path(__file__).parents[2] / "pyproject.toml"


@dataclass(frozen=True)
class Entry:
    extra: str = "files"
    modules: tuple[str, ...] = ("numpy", "no_such_module")


def test_what_lacks_is_named_with_its_install_command() -> None:
    need_for(Entry(modules=()))
    need_for(Entry(modules=("numpy",)))
    with pytest.raises(InputError, match=re.escape("no_such_module, which the base")) as refused:
        need_for(Entry())
    assert "pip install 'firstcontact[files]'" in str(refused.value)
    assert "numpy" not in str(refused.value)


@pytest.mark.parametrize(
    "registry", [IMPORTERS, EXPORTERS, MODEL_EXPORTERS, ESTIMATORS], ids=lambda r: r.kind
)
def test_entries_name_extras_that_exist(registry: object) -> None:
    assert isinstance(registry, type(IMPORTERS))
    there = tomllib.loads(PROJECT.read_text())["project"]["optional-dependencies"]
    for name, entry in registry.items():
        assert bool(entry.extra) == bool(entry.modules), name
        assert entry.extra in {"", *there}, name
