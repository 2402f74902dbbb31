"""Recordings at any rate, and contacts in the sample numbers of these recordings."""

from dataclasses import replace

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.signal import resample_dataset

pytestmark = pytest.mark.usefixtures("small_searches")

#: 4890 and 4985 Hz differ by less than 1 % from the rate of the model, 4936 Hz.
RATES = (2500.0, 4890.0, 4935.9, 4985.0, 10_000.0)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> fc.Dataset:
    folder = tmp_path_factory.mktemp("rates") / "pinches"
    return fc.simulate(folder, pinches_per_block=2, pinches_per_object=0, seed=3)


def recorded_at(data: fc.Dataset, rate: float) -> fc.Dataset:
    return replace(resample_dataset(data, rate), recorded_rate=None, notes=())


def times(contacts: object, data: fc.Dataset) -> list[float | None]:
    """Return the time of each contact after the start of its pinch, s."""
    assert isinstance(contacts, list)
    return [
        None if c is None else (c.sample - p.first_sample) / p.layout.rate
        for c, p in zip(contacts, data, strict=True)
    ]


@pytest.mark.parametrize("rate", RATES)
def test_contacts_have_the_sample_numbers_of_the_data(data: fc.Dataset, rate: float) -> None:
    model = fc.adapt()
    known = times([p.first for p in data], data)
    other = recorded_at(data, rate)
    predictions = model.predict(other)
    detected = fc.detect(other, model)
    assert predictions.contacts == detected == fc.detect(other)
    for time, known_time in zip(times(detected, other), known, strict=True):
        assert time == pytest.approx(known_time, abs=0.003)
    for contact, pinch in zip(detected, other, strict=True):
        assert contact.sample <= contact.decided < pinch.first_sample + len(pinch.data)


@pytest.mark.parametrize("rate", RATES)
def test_contacts_are_taken_at_the_rate_of_the_data(data: fc.Dataset, rate: float) -> None:
    model = fc.adapt()
    other = recorded_at(data, rate)
    truth = [p.first for p in other]
    given = model.predict(other, contacts=truth)
    known = model.predict(other, contacts="known")
    np.testing.assert_array_equal(given.value, known.value)
    assert given.contacts == known.contacts == truth
    as_model = model.predict(resample_dataset(other, model.rate), contacts="known")
    np.testing.assert_array_equal(known.value, as_model.value)
    if rate > model.rate:  # a lower rate cannot number each sample of the model
        detected = model.predict(other)
        again = model.predict(other, contacts=detected.contacts)
        np.testing.assert_array_equal(detected.value, again.value)


def test_training_at_nearly_the_rate_of_the_network_is_resampled(data: fc.Dataset) -> None:
    other = recorded_at(data, 4890.0)
    model = fc.train(other, "peak", detector="three_sigma")
    assert {p.rate for p in model.predictors} == {4936.0}
    assert len(fc.evaluate(model, other)) == len(model.predictors)


def test_an_unknown_word_for_the_contacts_is_refused(data: fc.Dataset) -> None:
    for word in ("truth", "x" * len(data)):
        with pytest.raises(fc.InputError) as caught:
            fc.adapt().predict(data, contacts=word)  # type: ignore[arg-type]
        assert caught.value.parameter == "contacts"
    bare = replace(data, pinches=tuple(replace(p, truth=()) for p in data))
    with pytest.raises(fc.InputError) as caught:
        fc.adapt().predict(bare, contacts="known")
    assert caught.value.parameter == "contacts"
