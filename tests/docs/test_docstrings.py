"""Examples in docstrings run."""

from __future__ import annotations

import doctest
from importlib import import_module

import pytest
from pages import ROOT

MODULES = [
    ".".join(path.relative_to(ROOT / "src").with_suffix("").parts)
    for path in sorted((ROOT / "src").rglob("*.py"))
    if ">>> " in path.read_text(encoding="utf-8")
]


def test_there_are_some() -> None:
    assert len(MODULES) > 5


@pytest.mark.parametrize("name", MODULES)
def test_it_runs(name: str) -> None:
    done = doctest.testmod(import_module(name))
    assert done.attempted
    assert not done.failed
