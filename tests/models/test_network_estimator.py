"""The network as an estimator: to fit it means to adapt it to a rig."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import firstcontact as fc
from firstcontact.core import Dataset, InputError
from firstcontact.models import (
    ESTIMATORS,
    RIG_ESTIMATOR,
    NetworkEstimator,
    Task,
    make_estimator,
    window_estimators,
)
from firstcontact.recording import load_dataset
from firstcontact.testing._windows import RATE, toy_windows
from trainings import recordings

pytestmark = pytest.mark.usefixtures("stored_detectors")


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return load_dataset(recordings(tmp_path_factory.mktemp("rig") / "p"))


def test_training_the_default_rig_estimator_is_adapting_it(data: Dataset, tmp_path: Path) -> None:
    trained, adapted = fc.train(data, RIG_ESTIMATOR.name, seed=2), fc.adapt(data, seed=2)
    assert trained.notes == adapted.notes
    assert not trained.windows
    for name, model in (("trained", trained), ("adapted", adapted)):
        model.save(tmp_path / name)
    files = sorted(path.name for path in (tmp_path / "trained").iterdir())
    assert files == sorted(path.name for path in (tmp_path / "adapted").iterdir())
    for name in files:
        both = [(tmp_path / folder / name).read_bytes() for folder in ("trained", "adapted")]
        assert both[0] == both[1], name


def test_known_contacts_are_used_on_request(data: Dataset) -> None:
    model = fc.train(data, "network", contacts="known")
    assert "known" in model.trained_on.contacts


@pytest.mark.parametrize(
    ("name", "value"),
    [("task", "classification"), ("windows", (0.005,)), ("level", 0.8), ("rate", 8000.0)],
)
def test_what_the_network_cannot_do_is_refused(data: Dataset, name: str, value: Any) -> None:
    with pytest.raises(InputError) as refused:
        fc.train(data, "network", **{name: value})
    assert refused.value.parameter == name


def test_it_is_registered_and_learns_from_no_windows() -> None:
    assert ESTIMATORS.find("network") is NetworkEstimator
    assert "network" not in window_estimators()
    with pytest.raises(InputError):
        make_estimator("network", Task.REGRESSION, RATE).fit(*toy_windows(20))
