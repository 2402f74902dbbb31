"""Plots, short descriptions and tables of what the front door returns."""

import base64
import re
from pathlib import Path

import numpy as np
import pytest

import firstcontact as fc

pytestmark = pytest.mark.filterwarnings("ignore:.*interactive.*")


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plots") / "recordings"
    data = fc.simulate(folder, pinches_per_block=3, pinches_per_object=0)
    model = fc.adapt(data)
    return {
        "pinch": data[0],
        "dataset": data,
        "predictions": model.predict(data),
        "evaluation": fc.evaluate(model, data)[0],
    }


@pytest.fixture(autouse=True)
def without_display():
    import matplotlib

    matplotlib.use("agg")


KINDS = ("pinch", "dataset", "predictions", "evaluation")


@pytest.mark.parametrize("kind", KINDS)
def test_it_draws_axes_with_data_and_labels(kind, shown):
    from matplotlib import pyplot

    axes = fc.plot(shown[kind])
    for each in axes if kind == "pinch" else [axes]:
        assert each.has_data()
        assert each.get_ylabel()
    assert (axes[-1] if kind == "pinch" else axes).get_xlabel()
    pyplot.close("all")


@pytest.mark.parametrize("kind", KINDS)
def test_it_describes_itself_in_one_line_and_as_a_picture(kind, shown):
    text = repr(shown[kind])
    assert len(text) < 100
    assert "array" not in text
    page = shown[kind]._repr_html_()
    image = re.search(r'src="data:image/png;base64,([^"]+)"', page)
    assert image
    assert base64.b64decode(image[1]).startswith(b"\x89PNG")
    assert len(page) < 200_000


def test_names_from_recordings_stay_text(shown):
    from dataclasses import replace

    pinch = replace(shown["pinch"], label=fc.Label(object="<script>$x$"))
    assert "<script>" not in pinch._repr_html_()


def test_an_empty_dataset_and_other_things(shown):
    assert "0 pinches" in fc.Dataset(())._repr_html_()
    with pytest.raises(fc.InputError) as refusal:
        fc.plot(Path())
    assert refusal.value.parameter == "subject"


def test_tables_have_a_row_for_each_and_units(shown):
    pytest.importorskip("pandas")
    data, predictions, evaluation = (shown[kind] for kind in KINDS[1:])
    table = data.to_frame()
    assert table["shore_a"].tolist() == data.shore_a.tolist()
    offset = 1e-3 * (table["second_contact_ms"] - table["first_contact_ms"])
    offsets = [np.nan if pinch.offset is None else pinch.offset for pinch in data]
    assert offset.tolist() == pytest.approx(offsets, nan_ok=True)
    table = predictions.to_frame()
    assert table["elapsed_ms"].tolist() == pytest.approx(1e3 * predictions.elapsed, nan_ok=True)
    assert len(table) == len(predictions)
    table = evaluation.to_frame()
    group = evaluation.groups[0]
    assert table["rmse"][: len(group.scores)].tolist() == list(group.rmse.values())


@pytest.mark.parametrize(("name", "n"), [("paper-rig", 190), ("everyday", 190), ("strikes", 60)])
def test_a_sample_is_made_once(name, n, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    data = fc.sample(name)
    assert len(data) == n
    assert data.source == "twin"
    assert not np.isnan(data.shore_a).any()
    files = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.mcap")}
    again = fc.sample(name)
    assert [pinch.data.tobytes() for pinch in again] == [pinch.data.tobytes() for pinch in data]
    assert files == {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.mcap")}


def test_another_sample_and_an_unwritable_cache_are_refused(tmp_path, monkeypatch):
    with pytest.raises(fc.InputError) as refusal:
        fc.sample("mine")
    assert refusal.value.parameter == "name"
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    with pytest.raises(fc.InputError, match="XDG_CACHE_HOME"):
        fc.sample("strikes")
