"""Fixtures of the tests of the experiments."""

from __future__ import annotations

from io import StringIO

import pytest


@pytest.fixture(scope="module", autouse=True)
def _quick_searches(small_searches: None) -> None:
    """Limit the hyperparameter search of every estimator."""


@pytest.fixture
def unpainted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Build figures, but do not paint them: painting takes longest, and other tests do it."""

    def save(figure: object, file: StringIO, **options: object) -> None:
        file.write("<svg/>")

    monkeypatch.setattr("matplotlib.figure.Figure.savefig", save)
