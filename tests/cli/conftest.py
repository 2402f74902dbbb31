"""Shared set-up of the command-line tests."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="module", autouse=True)
def _quick_training(small_searches: None) -> None:
    """Make trainings in these tests quick."""
