"""The network as an estimator: to fit it means to adapt it to a rig."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import firstcontact as fc
from firstcontact.core import Contact, Dataset, Finger, InputError
from firstcontact.models import ESTIMATORS, Task, make_estimator
from firstcontact.models.registry import window_estimators
from firstcontact.models.rig.network_estimator import MOST_OF_LEVEL, NetworkEstimator
from firstcontact.models.training_runs import RIG_ESTIMATOR
from firstcontact.recording import load_dataset
from firstcontact.testing.synthetic import RATE
from trainings import CONTACT, recordings

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


def test_pinches_that_end_too_early_do_not_count(data: Dataset) -> None:
    """In every other pinch the second contact follows after two samples."""
    second = Contact(Finger.THUMB, CONTACT + 2, CONTACT + 2)
    pinches = [
        replace(p, truth=(*p.truth, second)) if i % 2 else p
        for i, p in enumerate(data.pinches[:60])
    ]
    dataset = replace(data, pinches=tuple(pinches))
    model = fc.train(dataset, "network", contacts="known")
    assert model.network.record.pinches == 30
    assert "30 pinches" in model.notes[0]


@pytest.mark.parametrize(
    ("levels", "is_limited"), [((10.0, 29.0, 60.0), False), ((10.0, 60.0), True)]
)
def test_a_limit_on_the_pinches_of_a_level_is_stated(
    data: Dataset, levels: tuple[float, ...], is_limited: bool
) -> None:
    """The data have 20 pinches of each level. The middle level joins the lowest one."""
    pinches = tuple(
        replace(p, label=replace(p.label, shore_a=max(s for s in levels if s <= p.label.shore_a)))
        for p in data.pinches[:60]
    )
    model = fc.adapt(replace(data, pinches=pinches))
    assert (str(MOST_OF_LEVEL) in model.notes[0].partition(";")[2]) == is_limited


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
        make_estimator("network", Task.REGRESSION, RATE)
