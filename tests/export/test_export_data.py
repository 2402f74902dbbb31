"""Training pinches of an export: any rate, and at least one pinch."""

from pathlib import Path

import pytest

import firstcontact as fc
from firstcontact.core import Role

pytestmark = pytest.mark.usefixtures("stored_detectors")


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> fc.Dataset:
    folder = tmp_path_factory.mktemp("export") / "pinches"
    return fc.simulate(folder, pinches_per_block=12, pinches_per_object=2, seed=1)


@pytest.fixture(scope="module")
def model(data: fc.Dataset) -> fc.Model:
    return fc.adapt(data)


def test_an_export_without_training_pinches_is_refused(
    data: fc.Dataset, model: fc.Model, tmp_path: Path
) -> None:
    unseen = data[data.test]
    assert all(p.label.role is Role.TEST for p in unseen)
    for pinches in (data[:0], unseen):
        with pytest.raises(fc.InputError) as caught:
            fc.export_model(model, tmp_path / "c", to="c", data=pinches)
        assert caught.value.parameter == "data"
        assert not (tmp_path / "c").exists()
