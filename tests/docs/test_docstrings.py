"""Examples in docstrings run, and every public name has one."""

import doctest
import re
from importlib import import_module
from pathlib import Path
from typing import get_args

import pytest
from pages import ROOT

import firstcontact as fc

pytestmark = pytest.mark.usefixtures("small_searches")
MODULES = [
    ".".join(path.relative_to(ROOT / "src").with_suffix("").parts)
    for path in sorted((ROOT / "src").rglob("*.py"))
    if ">>> " in path.read_text(encoding="utf-8")
]


@pytest.fixture(scope="session")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write the recordings that the examples use, as the reference page states."""
    folder = tmp_path_factory.mktemp("examples") / "recordings"
    fc.simulate(folder, pinches_per_block=12, pinches_per_object=0)
    return folder


def test_examples_exist() -> None:
    assert len(MODULES) > 5


@pytest.mark.parametrize("name", MODULES)
def test_it_runs(
    name: str, recordings: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "recordings").symlink_to(recordings)
    monkeypatch.chdir(tmp_path)
    outcome = doctest.testmod(import_module(name))
    assert outcome.attempted
    assert not outcome.failed


def test_every_name_for_users_has_a_runnable_example() -> None:
    names = {*fc.__all__, "open"}
    texts = [fc.plugins.__doc__, *(getattr(fc, name).__doc__ for name in names)]
    examples = " ".join((text or "").partition("Examples\n")[2] for text in texts)
    # The example of live shows how a program tells events apart.
    events = {kind.__name__ for kind in get_args(fc.Event)}
    assert names - set(re.findall(r"\w+", examples)) - events == set()
