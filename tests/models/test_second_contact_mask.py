"""No model predicts from samples after a known second contact."""

from dataclasses import replace

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.core import Contact, Dataset, Finger
from firstcontact.models import Model
from firstcontact.recording import load_dataset
from firstcontact.signal import SavitzkyGolay, samples_in
from trainings import CONTACT, recordings

pytestmark = pytest.mark.usefixtures("stored_detectors")

LENGTHS = (0.003, 0.008)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return load_dataset(recordings(tmp_path_factory.mktemp("mask") / "p"))


@pytest.fixture(scope="module")
def model(data: Dataset) -> Model:
    return fc.train(data, "peak", windows=LENGTHS)


def with_second(data: Dataset, second_delay: int) -> Dataset:
    """Return the pinches with a second contact after a delay, and noise from that contact on."""
    rng = np.random.default_rng(0)
    pinches = []
    for pinch in data.pinches:
        at = pinch.first_sample + CONTACT + second_delay
        samples = pinch.data.copy()
        samples[CONTACT + second_delay :] = rng.integers(
            0, 32767, samples[CONTACT + second_delay :].shape
        )
        truth = pinch.truth[:1] + (pinch.truth[1:] or (Contact(Finger.THUMB, at, at),))
        pinches.append(replace(pinch, data=samples, truth=truth))
    return Dataset(tuple(pinches), data.source)


def samples(seconds: float) -> int:
    """Return the number of samples that a window of this length depends on through its filter."""
    return samples_in(seconds, 4936.0) + SavitzkyGolay().lookahead


@pytest.mark.parametrize("estimator", ["peak", "network"])
def test_what_follows_the_second_contact_changes_no_prediction(
    data: Dataset, model: Model, estimator: str
) -> None:
    late = with_second(data, samples(LENGTHS[1]))
    contacts = [p.first for p in data.pinches]
    touched = model.predict(late, contacts=contacts, estimator=estimator)
    alone = model.predict(data, 0.008, contacts=contacts, estimator=estimator)
    assert np.isfinite(touched.value).all()
    if estimator == "peak":
        np.testing.assert_array_equal(touched.value, alone.value)
    else:
        again = model.predict(with_second(late, 60), contacts=contacts, estimator=estimator)
        np.testing.assert_array_equal(touched.value, again.value)


def test_evaluation_leaves_out_windows_that_reach_the_second_contact(
    data: Dataset, model: Model
) -> None:
    alone = fc.evaluate(model, data, contacts="known")[:2]
    late = fc.evaluate(model, with_second(data, samples(LENGTHS[0])), contacts="known")[:2]
    assert [e.duration for e in late] == list(LENGTHS)
    assert [g.scores for g in late[0].groups] == [g.scores for g in alone[0].groups]
    assert (late[1].scored, late[1].groups, late[1].left_out) == (0, (), len(data))
    with pytest.raises(fc.InputError) as caught:
        fc.evaluate(
            model.only("peak"), with_second(data, samples(LENGTHS[0]) - 1), contacts="known"
        )
    assert caught.value.parameter == "data"


def test_a_shorter_window_stands_in_and_before_the_first_there_is_none(
    data: Dataset, model: Model
) -> None:
    contacts = [p.first for p in data.pinches]
    for second_delay, length in (
        (samples(LENGTHS[1]), LENGTHS[1]),
        (samples(LENGTHS[1]) - 1, LENGTHS[0]),
        (samples(LENGTHS[0]), LENGTHS[0]),
        (samples(LENGTHS[0]) - 1, float("nan")),
    ):
        touched = with_second(data, second_delay)
        predictions = model.predict(touched, contacts=contacts, estimator="peak")
        rate = data.layout.rate
        elapsed = length if np.isnan(length) else samples_in(length, rate) / rate
        np.testing.assert_array_equal(predictions.elapsed, np.full(len(data), elapsed))
        assert np.isnan(predictions.value).all() == np.isnan(length)
