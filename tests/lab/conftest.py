"""Fixture of all tests of the lab."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="module", autouse=True)
def quick_training(small_searches: None) -> None:
    """Train quickly: the lab's tests are not about the search for hyperparameters."""
