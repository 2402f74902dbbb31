"""Shape hints of the user, live and as labels of recordings."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import firstcontact as fc
from firstcontact.core import InputError, Role
from firstcontact.core.physics import LEAST, MOST, parse_radius, radius_text
from firstcontact.models import Touches
from firstcontact.twin.objects import OBJECTS


@given(st.floats(LEAST, MOST))
def test_a_radius_in_mm_is_one_in_m(mm: float) -> None:
    assert parse_radius(f" {mm!r} mm ") == pytest.approx(mm / 1000)
    assert parse_radius(
        radius_text(parse_radius(str(mm))).removeprefix("radius ")
    ) == pytest.approx(mm / 1000, rel=1e-4)


def test_flat_and_nothing() -> None:
    assert parse_radius(" Flat") == math.inf
    assert radius_text(math.inf) == "flat"
    assert math.isnan(parse_radius(""))
    assert radius_text(None) == radius_text(math.nan) == ""


@pytest.mark.parametrize("text", ["round", "-3", "inf", "1e9", "4.9", "201", "37 cm"])
@pytest.mark.parametrize("read", [parse_radius, lambda text: fc.Label(shape=text)])
def test_what_is_no_shape_is_refused(text: str, read: Callable[[str], object]) -> None:
    with pytest.raises(InputError) as refused:
        read(text)
    assert refused.value.parameter == "shape"


def known_shape(name: str) -> str:
    """Return the shape of an object of the twin."""
    radius = OBJECTS[name].nominal.radius
    return f"{1000 * radius:g} mm" if radius < 1 else "flat"


def with_shapes(data: fc.Dataset, shape: Callable[[str], str]) -> fc.Dataset:
    """Return pinches whose labels state the shapes of their objects, given by name."""
    labels = (replace(p.label, shape=shape(p.label.object)) for p in data)
    return replace(data, pinches=tuple(map(lambda p, at: replace(p, label=at), data, labels)))


def test_shapes_in_labels_are_inputs_of_the_network(
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    folder = tmp_path_factory.mktemp("shapes") / "pinches"
    data = fc.simulate(folder, pinches_per_block=8, pinches_per_object=2, seed=5)
    assert all(p.label.shape == ("" if p.label.role is Role.TEST else "flat") for p in data)
    shaped = with_shapes(data, known_shape)
    data = with_shapes(data, lambda name: "")
    learnt = (np.arange(len(data)) % 2 == 0) & ~data.test
    model = fc.adapt(shaped[learnt])
    # Blocks without a shape condition the model in the same way.
    plain = model.predict(data, contacts="known")
    assert np.array_equal(
        plain.value, fc.adapt(data[learnt]).predict(data, contacts="known").value, equal_nan=True
    )
    predictions = model.predict(shaped, contacts="known")
    touches, rows = Touches.cut(data, [pinch.first for pinch in data])
    shapes = [known_shape(data[row].label.object) for row in rows]
    assert set(shapes) == {"flat", "37 mm", "33 mm", "34 mm"}
    radii = np.array([parse_radius(shape) for shape in shapes])
    enough = touches.answerable
    touches, rows = replace(touches, radii=radii).take(enough), rows[enough]
    # Recordings are predicted at the moments of live sessions.
    moments = np.array(model.network.lengths)
    newest = moments[np.searchsorted(moments, touches.valid, side="right") - 1]
    touches = replace(touches, valid=newest)
    assert predictions.value[rows] == pytest.approx(model.network.predict_touches(touches).value)
    flat = ~data.test & ~learnt & np.isfinite(plain.value)
    errors = [np.abs(p.value - data.shore_a)[flat].mean() for p in (predictions, plain)]
    assert errors[0] < errors[1]


def test_objects_of_the_training_are_evaluated_as_flat_blocks(tmp_path: Path) -> None:
    data = fc.simulate(tmp_path / "pinches", pinches_per_block=8, pinches_per_object=0, seed=6)
    unknown = with_shapes(data, lambda name: "")
    model, bare = fc.adapt(data), fc.adapt(unknown)
    assert {n: a.tolist() for n, a in model.predictors[0].to_arrays().items()} == {
        n: a.tolist() for n, a in bare.predictors[0].to_arrays().items()
    }

    def bias(pinches: fc.Dataset) -> float:
        (evaluation,) = fc.evaluate(model, pinches, contacts="known")
        return evaluation.groups[0].bias[0.005]

    assert bias(unknown) == bias(data)
    # A round object yields more than a flat one, so with the same signal it must be harder.
    test = tuple(replace(p, label=replace(p.label, role=Role.TEST)) for p in unknown)
    assert bias(replace(unknown, pinches=test)) > bias(data)
    assert bias(with_shapes(data, lambda name: "20 mm")) > bias(data)
