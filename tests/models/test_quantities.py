"""Models of a modulus or a stiffness: learned as logarithms, predicted and scored in their unit."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.core import Dataset, InputError, Label
from firstcontact.core.physics import gent_modulus
from firstcontact.core.quantity import MODULUS, STIFFNESS
from firstcontact.models.model import load_model
from firstcontact.recording.dataset import load_dataset, write_dataset
from firstcontact.recording.messages import Header
from toy_pinches import shore_dataset
from trainings import recordings

#: Stiffness of an object with each Shore A of the toy pinches, N/mm.
SPRINGS = {10.0: 5.0, 20.0: 8.0, 30.0: 15.0, 50.0: 30.0, 60.0: 45.0}


def relabelled(data: Dataset, **values: object) -> Dataset:
    """Return the dataset with other labels; a callable gets the Shore A."""

    def label(old: Label) -> Label:
        given = {k: v(old.shore_a) if callable(v) else v for k, v in values.items()}
        return replace(old, **{"shore_a": None, **given})

    return replace(data, pinches=tuple(replace(p, label=label(p.label)) for p in data))


def recorded(data: Dataset, folder: Path) -> str:
    """Return the path of a recording of these pinches."""
    header = Header(data.layout, source="synthetic", dtype="float32")
    return str(write_dataset(data, folder, header)[0])


@pytest.fixture(scope="module")
def springs() -> Dataset:
    return relabelled(shore_dataset(each=18), stiffness_n_per_mm=lambda shore: SPRINGS[shore])


@pytest.fixture(scope="module")
def model(springs: Dataset) -> fc.Model:
    return fc.train(springs, windows=[0.005, 0.015], contacts="known")


def test_predictions_are_in_the_unit_of_the_labels(springs, model):
    learned = springs[~springs.test]
    made = model.predict(learned, contacts="known")
    assert made.target == STIFFNESS.name
    factors = np.exp(np.abs(np.log(made.value / learned.label_values(STIFFNESS))))
    assert np.median(factors) < 1.3
    assert (made.low > 0).all()
    assert (made.low < made.value).all()
    # Ends of an interval are factors away from the value.
    assert np.allclose(made.value / made.low, made.high / made.value, rtol=1e-4)


def test_scores_are_factors_of_the_mean_of_logarithms(springs, model):
    *_, last = fc.evaluate(model, springs, contacts="known")
    seen = next(group for group in last.groups if group.title == "seen in training")
    logarithms = np.log(springs.label_values(STIFFNESS)[~springs.test])
    assert last.quantity is STIFFNESS
    assert seen.constant == pytest.approx(logarithms.std())
    [rmse] = seen.rmse.values()
    assert 0 < rmse < seen.constant / 2
    assert sorted(row.true for row in seen.objects.values()) == pytest.approx([5, 15, 45])
    assert any("rmse factor 1." in note for note in model.notes)


def test_a_saved_model_predicts_the_same(springs, model, tmp_path: Path):
    again = load_model(model.save(tmp_path / "model"))
    before, after = (m.predict(springs[:5], contacts="known") for m in (model, again))
    assert np.array_equal(before.value, after.value)
    assert np.array_equal(before.high, after.high)
    card = json.loads((tmp_path / "model" / "model.json").read_text())
    assert card["trained_on"]["target"] == STIFFNESS.name


def test_a_live_session_and_its_text_say_the_unit(springs, model, tmp_path: Path):
    words = []
    with fc.open(recorded(springs[:3], tmp_path), speed=math.inf) as source:
        for event in fc.live(source, model=model):
            if isinstance(event, fc.Estimate):
                words.append((event.quantity, event.words, event.modulus_mpa))
    assert words
    assert all(q == STIFFNESS.name and " N/mm (" in w and m is None for q, w, m in words)


def test_a_modulus_also_gives_the_network(tmp_path: Path):
    data = load_dataset(recordings(tmp_path / "p"))
    data = relabelled(data, modulus_mpa=lambda shore: 1e-6 * gent_modulus(shore))
    made = fc.train(data, contacts="known")
    by_name = {p.name: p.quantity.name for p in made.predictors}
    assert by_name == {"combined": "shore_a", "svm": MODULUS.name}
    of_svm = made.predict(data[:4], contacts="known", estimator="svm")
    assert np.median(np.abs(np.log(of_svm.value / data[:4].label_values(MODULUS)))) < 0.5
    scored = {e.predictor: e.target for e in fc.evaluate(made, data, contacts="known")}
    assert scored == by_name


def test_classes_are_values_and_not_logarithms(springs):
    made = fc.train(springs, "svm", task="classification", contacts="known")
    values = made.predict(springs[:6], contacts="known").value
    assert set(values[np.isfinite(values)]) <= {5.0, 15.0, 45.0}


def test_two_quantities_are_refused(springs):
    mixed = replace(springs, pinches=(*springs.pinches, *shore_dataset(each=3).pinches))
    with pytest.raises(InputError, match=r"shore_a and stiffness_n_per_mm"):
        fc.train(mixed)


def test_a_policy_that_acts_on_shore_a_is_refused(springs, model, tmp_path: Path):
    with (
        fc.open(recorded(springs[:1], tmp_path), speed=math.inf) as source,
        pytest.raises(InputError) as caught,
    ):
        next(iter(fc.live(source, model=model, hand="print", policy="stiffness")))
    assert caught.value.parameter == "policy"
