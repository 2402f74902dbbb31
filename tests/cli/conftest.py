"""Shared set-up of the command-line tests."""

from pathlib import Path

import pytest

from trainings import recordings


@pytest.fixture(scope="module", autouse=True)
def _quick_training(small_searches: None) -> None:
    """Make trainings in these tests quick."""


@pytest.fixture(scope="session")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return recordings of three blocks and an unseen object. No test may change them."""
    return recordings(tmp_path_factory.mktemp("blocks") / "pinches")
