"""SVM detector: training, its plain arrays, and refusals."""

from dataclasses import replace

import numpy as np
import pytest

from firstcontact.contact import SvmDetector, detect
from firstcontact.contact.svm import WIDTH, RbfMachine
from firstcontact.core import Dataset, InputError, Pinch
from firstcontact.testing import closings
from firstcontact.testing.synthetic import LAYOUT, closing


def test_separates_contacts_from_clicks(fitted):
    right = 0
    for pinch in closings(30, seed=2).pinches:
        contacts = detect(fitted["svm"], pinch)
        right += bool(contacts) and (
            contacts[0].finger is pinch.first.finger
            and abs(contacts[0].sample - pinch.first.sample) <= 15
        )
    assert right >= 27


def test_decision_equals_that_of_scikit_learn():
    from sklearn.svm import SVC

    rng = np.random.default_rng(0)
    x = rng.normal(size=(300, 4)) * [1, 5, 0.1, 2] + 3
    y = (x[:, 0] > 3) ^ (x[:, 1] > 3)
    ours = RbfMachine.train(x, y, cost=100.0)
    scaled = (x - x.mean(axis=0)) / x.std(axis=0)
    theirs = SVC(C=100.0, gamma=WIDTH / 4, class_weight="balanced").fit(scaled, y)
    np.testing.assert_allclose(ours.decide(x), theirs.decision_function(scaled), atol=1e-9)


@pytest.mark.parametrize("name", ["support", "weights", "threshold", "rate", "gamma"])
def test_broken_arrays_are_refused(fitted, name):
    arrays = fitted["svm"].to_arrays()
    missing = {k: v for k, v in arrays.items() if k != name}
    with pytest.raises(InputError, match=f"{name!r}"):
        SvmDetector.from_arrays(missing)
    with pytest.raises(InputError):
        SvmDetector.from_arrays(arrays | {name: np.full_like(arrays[name], np.nan)})
    for wrong in ({"support": arrays["support"][:, :-1]}, {"scale": arrays["scale"] * 0}):
        with pytest.raises(InputError):
            SvmDetector.from_arrays(arrays | wrong)


def test_untrained_detector_is_refused():
    with pytest.raises(InputError):
        SvmDetector().chain_constants(LAYOUT.rate)
    with pytest.raises(InputError):
        SvmDetector().to_arrays()


def test_training_on_too_few_contacts_is_refused():
    flat = replace(closing(1), data=np.full((1200, 16), 16384, dtype=np.int16))
    for dataset in (
        Dataset(()),
        Dataset((closing(1, touches=False),) * 3),
        Dataset((closing(1),)),
        Dataset((flat, flat)),
    ):
        with pytest.raises(InputError):
            SvmDetector().fit(dataset)


def test_trains_on_one_channel_and_first_contacts():
    pinches = []
    for pinch in closings(30, seed=6).pinches:
        column = pinch.first.finger
        layout = replace(LAYOUT, channels=(LAYOUT.channels[column],))
        pinches.append(
            Pinch(pinch.data[:, [column]], layout, pinch.label, pinch.first_sample, pinch.truth[:1])
        )
    detector = SvmDetector().fit(Dataset(tuple(pinches[:20])))
    contacts = [detect(detector, p) for p in pinches[20:]]
    assert sum(bool(c) for c in contacts) >= 8
