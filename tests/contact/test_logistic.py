"""Logistic detector: training, its 17 parameters, decisions, and transfer to another rig."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from firstcontact.chain.touch import fit_predictions, look_features
from firstcontact.contact import detect
from firstcontact.contact.logistic import (
    EACH,
    FLOOR,
    LOOKS,
    ORDER,
    LogisticDetector,
    add_clicks,
    best_threshold,
    parts,
)
from firstcontact.core import Dataset, InputError
from firstcontact.testing import closings
from firstcontact.testing.synthetic import LAYOUT, closing


def test_finds_contacts_within_the_latency(fitted):
    """The decision comes soon after the contact lies in all the windows that must agree."""
    span = (LOOKS - 1) * LogisticDetector.sizes(LAYOUT.rate).step
    ages = []
    for pinch in closings(30, seed=2).pinches:
        contacts = detect(fitted["logistic"], pinch)
        if contacts and contacts[0].finger is pinch.first.finger:
            ages.append(contacts[0].decided - pinch.first.sample)
    assert len(ages) >= 27
    assert span <= np.median(ages) <= 0.0025 * LAYOUT.rate


def test_contacts_do_not_depend_on_the_gain(fitted):
    """Features are relative to the noise of the rig."""
    for seed in range(8):
        pinch = closing(seed)
        quieter = pinch.data.copy()
        quieter[:, :2] = 16384 + (quieter[:, :2].astype(np.int32) - 16384) // 4
        contacts, quieter_contacts = (
            detect(fitted["logistic"], p) for p in (pinch, replace(pinch, data=quieter))
        )
        assert [c.finger for c in contacts] == [c.finger for c in quieter_contacts]
        assert all(
            abs(a.decided - b.decided) <= 2 for a, b in zip(contacts, quieter_contacts, strict=True)
        )


def test_contact_louder_than_the_training_data_is_detected(fitted):
    for seed in range(5):
        pinch = closing(seed)
        data = pinch.data.astype(np.float64)
        t = pinch.first.sample - pinch.first_sample
        age = np.arange(len(data) - t)
        data[t:, pinch.first.finger] += 3e6 * np.exp(-age / 30) * np.sin(0.4 * age + 0.3)
        contact = detect(fitted["logistic"], replace(pinch, data=data))[0]
        assert contact.finger is pinch.first.finger
        assert abs(contact.sample - pinch.first.sample) <= 5


def test_prediction_residual_is_white_with_unit_power():
    rng = np.random.default_rng(3)
    ringing = lfilter([1.0], [1.0, -1.6, 0.8], rng.standard_normal(3000))
    ringing /= ringing[:2000].std()
    (weights,) = fit_predictions(ringing[None, :2000])
    residual = np.convolve(ringing, weights, mode="valid")
    assert residual[2000:].std() == pytest.approx(1.0, abs=0.1)
    assert abs(np.corrcoef(residual[1:], residual[:-1])[0, 1]) < 0.1
    assert not fit_predictions(np.zeros((1, 200))).any()


@pytest.mark.parametrize("rate", [LogisticDetector.lowest, 2200.0, 4936.0, 16_000.0])
def test_loudness_features_follow_the_newest_part(rate):
    """If noise doubles its amplitude in the newest 3 ms, only those features rise, by log 2."""
    rng = np.random.default_rng(0)
    n = LogisticDetector.sizes(rate).window
    x = 1e7 * rng.standard_normal((400, n))
    x -= x[:, : n - round(0.006 * rate)].mean(axis=1, keepdims=True)  # what levels are taken about
    newest = round(0.003 * rate)
    louder = x.copy()
    louder[:, n - newest :] *= 2.0
    weights = np.tile(np.eye(1, ORDER + 1), (400, 1))
    features = [look_features(looks, weights, parts(rate), FLOOR) for looks in (x, louder)]
    gained = (features[1] - features[0]).reshape(400, 2, EACH)
    assert gained[:, :, 1:4] == pytest.approx(np.log(2.0), abs=1e-3)
    assert gained[:, :, 0] == pytest.approx(0.0, abs=1e-3)


def test_clicks_are_added_only_before_the_contact():
    rng = np.random.default_rng(2)
    x = rng.standard_normal(800)
    clicked = add_clicks(x, fit_predictions(x[None, :197])[0], 400, np.random.default_rng(5))
    assert np.abs(clicked - x)[:400].max() > 2.0
    assert np.abs(clicked - x)[500:].max() < 0.01


def test_threshold_is_the_middle_of_the_margin():
    quiet, loud = np.full(50, -4.0), np.full(50, 8.0)
    assert best_threshold(np.stack([quiet, loud], axis=1)) == pytest.approx(2.0, abs=0.05)
    quiet[0] = 7.0  # one click does not drag it along
    assert best_threshold(np.stack([quiet, loud], axis=1)) < 4.0


@pytest.mark.parametrize("name", ["line", "rate"])
def test_broken_arrays_are_refused(fitted, name):
    arrays = fitted["logistic"].to_arrays()
    huge = np.full_like(arrays[name], 1e308)  # finite, and scores overflow
    for broken in (np.full((3, 3), 1.0), np.full_like(arrays[name], np.nan), huge):
        with pytest.raises(InputError, match=f"{name!r}"):
            LogisticDetector.from_arrays(arrays | {name: broken})
    with pytest.raises(InputError, match="1020 Hz"):
        LogisticDetector.from_arrays(arrays | {"rate": np.asarray(LogisticDetector.lowest - 1)})


def test_training_on_too_few_contacts_is_refused():
    with pytest.raises(InputError):
        LogisticDetector().fit(Dataset((closing(1),)))


def test_training_on_contacts_that_follow_the_start_too_soon_is_refused():
    """Up to LOOKS - 1 looks at the motor alone have no agreed score."""
    sizes = LogisticDetector.sizes(LAYOUT.rate)
    for looks in range(LOOKS + 1):
        pinches = []
        for pinch in closings(8, seed=3).pinches:
            start = pinch.first.sample - sizes.steady - looks * sizes.step
            data = pinch.data[start - pinch.first_sample :]
            pinches.append(replace(pinch, data=data, first_sample=start, motor_start=start))
        if looks < LOOKS:
            with pytest.raises(InputError):
                LogisticDetector().fit(Dataset(tuple(pinches)))
        else:
            assert LogisticDetector().fit(Dataset(tuple(pinches))).trained
