"""Fixtures of the tests of the experiments."""

from collections.abc import Iterable, Iterator
from importlib.metadata import EntryPoint, entry_points
from io import StringIO

import pytest

from firstcontact.models import ESTIMATORS


@pytest.fixture(scope="module", autouse=True)
def _quick_training(small_searches: None) -> Iterator[None]:
    """Limit the hyperparameter search of every estimator, and the epochs of the CNN."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("firstcontact.models.windows.cnn.Cnn.quick", {"epochs": 1})
        patch.setattr("firstcontact.models.windows.log_spectrum.C_GRID", (1.0,))
        yield


@pytest.fixture(scope="module")
def own_estimators() -> Iterator[None]:
    """Hide estimators of other packages, because whole studies would train them."""

    def without_estimators(group: str) -> Iterable[EntryPoint]:
        return () if group == ESTIMATORS.group else entry_points(group=group)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("firstcontact.core.registry.entry_points", without_estimators)
        ESTIMATORS.reload()
        yield
    ESTIMATORS.reload()


@pytest.fixture(scope="module")
def unpainted() -> Iterator[None]:
    """Build figures without rendering them. Rendering is slow, and other tests cover it."""

    def save(figure: object, file: StringIO, **options: object) -> None:
        file.write("<svg/>")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("matplotlib.figure.Figure.savefig", save)
        yield
