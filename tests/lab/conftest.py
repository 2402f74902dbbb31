"""Fixtures of the tests of the experiments."""

from __future__ import annotations

from collections.abc import Iterator
from io import StringIO

import pytest

from firstcontact.models import ESTIMATORS


@pytest.fixture(scope="module", autouse=True)
def _quick_training(small_searches: None) -> Iterator[None]:
    """Limit the hyperparameter search of every estimator, and the epochs of the CNN."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("firstcontact.models._cnn.Cnn.quick", {"epochs": 1})
        patch.setattr("firstcontact.models._log_spectrum.C_GRID", (1.0,))
        yield


@pytest.fixture
def own_estimators(monkeypatch: pytest.MonkeyPatch) -> None:
    """Hide estimators of other packages, because whole studies would train them."""
    monkeypatch.setattr(ESTIMATORS, "_plugins", {})


@pytest.fixture
def unpainted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Build figures without rendering them, because rendering is slow and other tests cover it."""

    def save(figure: object, file: StringIO, **options: object) -> None:
        file.write("<svg/>")

    monkeypatch.setattr("matplotlib.figure.Figure.savefig", save)
