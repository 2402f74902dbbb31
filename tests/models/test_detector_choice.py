"""Choice between the package's detector and one that is fitted to a rig."""

import sys
from dataclasses import replace

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.contact.detector_file import is_pretrained
from firstcontact.core import Dataset, Pinch, installation
from firstcontact.jobs import Serial
from firstcontact.models.alignment import choose_detector, detect_alignment, fit_detector
from firstcontact.signal import resample_dataset
from firstcontact.testing.synthetic import closings


def with_swell(pinch: Pinch, rng: np.random.Generator) -> Pinch:
    """Add a swell before the first contact that looks like the push of a soft object."""
    data = pinch.data.astype(np.float64)
    start = pinch.first.sample - pinch.first_sample - int(rng.integers(80, 150))
    data[start : start + 60, :2] += 32 * 45 * np.sin(np.pi * np.arange(60) / 60)[:, None]
    return replace(pinch, data=np.clip(np.rint(data), 0, 32767).astype(np.int16))


@pytest.fixture(scope="module")
def plain() -> Dataset:
    return closings(24)


@pytest.fixture(scope="module")
def swelling(plain: Dataset) -> Dataset:
    rng = np.random.default_rng(1)
    return Dataset(tuple(with_swell(pinch, rng) for pinch in plain.pinches), plain.source)


def test_package_detector_is_taken_if_both_place_alike(plain: Dataset) -> None:
    detector, alignment, reason = choose_detector(plain, None, False, 0, Serial())
    assert is_pretrained(detector)
    assert "of the package" in alignment.how
    assert reason


def test_fitted_detector_is_taken_if_it_places_clearly_more(swelling: Dataset) -> None:
    """A rig with swells before each contact: the package's detector takes them for contacts."""
    detector, alignment, reason = choose_detector(swelling, None, False, 0, Serial())
    assert not is_pretrained(detector)
    fitted = fit_detector(swelling)
    for name, array in fitted.to_arrays().items():
        assert np.array_equal(detector.to_arrays()[name], array)
    assert "learned from other sessions" in alignment.how
    assert reason


def test_one_pinch_more_is_no_clear_difference(plain: Dataset, swelling: Dataset) -> None:
    one = Dataset((swelling.pinches[0], *plain.pinches[1:]), plain.source)
    assert is_pretrained(choose_detector(one, None, False, 0, Serial())[0])


def test_named_detector_is_fitted_without_a_choice(plain: Dataset) -> None:
    detector, _, reason = choose_detector(plain, "logistic", False, 0, Serial())
    assert not is_pretrained(detector)
    assert not reason


def test_package_detector_does_not_compete_at_another_rate(plain: Dataset) -> None:
    fast = resample_dataset(plain, 8000.0)
    detector, _, reason = choose_detector(fast, None, False, 0, Serial())
    assert detector.rate == 8000.0
    assert not reason


def test_pinches_without_known_contacts_take_the_package_detector(plain: Dataset) -> None:
    unknown = Dataset(tuple(replace(p, truth=()) for p in plain.pinches), plain.source)
    detector, _, reason = choose_detector(unknown, None, False, 0, Serial())
    assert is_pretrained(detector)
    assert not reason


def test_base_install_takes_the_package_detector(
    plain: Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(installation, "find_spec", lambda module: None)
    monkeypatch.setitem(sys.modules, "sklearn", None)
    detector, _, reason = choose_detector(plain, None, False, 0, Serial())
    assert is_pretrained(detector)
    assert "extra 'train'" in reason
    for call in (lambda: fc.train(plain), lambda: fit_detector(plain)):
        with pytest.raises(fc.InputError, match=r"\[train\]"):
            call()


def test_few_known_contacts_give_the_package_detector(plain: Dataset) -> None:
    """All known contacts are of one session, so none is left to learn from without that session."""
    pinches = tuple(
        replace(p, truth=p.truth if i < 4 else (), label=replace(p.label, session="ab"[i >= 4]))
        for i, p in enumerate(plain.pinches[:6])
    )
    few = Dataset(pinches, plain.source)
    detector, alignment, reason = choose_detector(few, None, False, 0, Serial())
    assert is_pretrained(detector)
    assert alignment.contacts == detect_alignment(few, detector).contacts
    assert reason
    _, known_alignment, _ = choose_detector(few, None, True, 0, Serial())
    assert known_alignment.contacts == [p.first for p in pinches]
