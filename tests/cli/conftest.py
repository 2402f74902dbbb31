"""Shared helpers of the command-line tests."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from firstcontact.cli.main import main


@pytest.fixture
def refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Callable[..., None]:
    """Return a function that runs ``import`` and asserts a refusal.

    The refusal must be one printed sentence with the given words, and nothing may be written.
    """

    def check(path: Path, *words: str, more: tuple[str, ...] = ()) -> None:
        out = tmp_path / "out"
        original = sorted(tmp_path.rglob("*"))
        assert main(["import", str(path), "--out", str(out), *more]) == 2
        message = capsys.readouterr().err
        assert message.count("\n") == 1, message
        for word in words:
            assert word in message
        assert sorted(tmp_path.rglob("*")) == original

    return check


@pytest.fixture(scope="module", autouse=True)
def _quick_training(small_searches: None) -> None:
    """Make trainings in these tests quick."""
