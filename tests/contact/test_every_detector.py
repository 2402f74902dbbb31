"""Conformance tests of all registered detectors, plug-ins included."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from firstcontact.contact import DETECTORS, Detector, detect, make_detector
from firstcontact.contact.contacts import judge_windows
from firstcontact.core import Block, Dataset, InputError
from firstcontact.signal import samples_in
from firstcontact.testing import check_detector
from firstcontact.testing.synthetic import LAYOUT, closing

STEADY = samples_in(Detector.steady, LAYOUT.rate)


@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.slow) for n in (1, 2))])
@pytest.mark.parametrize("name", DETECTORS)
def test_registered_detector_passes_the_conformance_check(name: str, seed: int) -> None:
    check_detector(DETECTORS[name], seed)


@pytest.mark.parametrize("name", DETECTORS)
def test_a_second_fit_to_the_same_pinches_learns_the_same(
    name: str, fitted: dict[str, Detector], training: Dataset
) -> None:
    if fitted[name].learns:
        again = make_detector(name).fit(training).to_arrays()
        assert fitted[name].to_arrays().keys() == again.keys()
        for key, learned in fitted[name].to_arrays().items():
            np.testing.assert_array_equal(again[key], learned)


class Loud(Detector):
    name = "loud"

    def fires(self, windows: NDArray[np.float64]) -> NDArray[np.bool_]:
        return np.asarray(np.abs(windows[:, :, -15:]).max(axis=2) > 8.0)


def test_custom_detector_passes_the_conformance_check() -> None:
    check_detector(Loud)


class Deaf(Loud):
    def fires(self, windows: NDArray[np.float64]) -> NDArray[np.bool_]:
        return np.zeros(windows.shape[:2], dtype=np.bool_)


class Moody(Loud):
    """Faulty detector that remembers earlier windows."""

    def __init__(self) -> None:
        self.count = 0

    def fires(self, windows: NDArray[np.float64]) -> NDArray[np.bool_]:
        self.count += 1
        return super().fires(windows) & (self.count % 7 > 0)


def test_conformance_check_rejects_faulty_detectors() -> None:
    with pytest.raises(AssertionError, match="nothing to check"):
        check_detector(Deaf)
    with pytest.raises(AssertionError, match="earlier closing"):
        check_detector(Moody)
    with pytest.raises(AssertionError, match="the detector has no title"):
        check_detector(type("Nameless", (Loud,), {"title": ""}))


def test_verdicts_begin_after_the_steady_state(detector: Detector) -> None:
    verdicts = judge_windows(detector, LAYOUT, Block(closing(8).data, 500))
    assert verdicts.ends[0] == 500 + STEADY + samples_in(detector.step, LAYOUT.rate) - 1
    pinch = closing(12)
    assert detect(detector, replace(pinch, data=pinch.data[: STEADY + 14], truth=())) == []


def at_rate(rate: float) -> Dataset:
    """Return closings at another sampling rate."""
    pinches = [closing(seed) for seed in range(8)]
    return Dataset(tuple(replace(p, layout=replace(p.layout, rate=rate)) for p in pinches))


@pytest.mark.parametrize("name", [n for n, kind in DETECTORS.items() if kind.learns])
def test_rates_below_the_lowest_are_refused(name: str) -> None:
    lowest = DETECTORS[name].lowest
    assert make_detector(name).fit(at_rate(lowest)).rate == lowest
    with pytest.raises(InputError, match=f"{lowest:g} Hz"):
        make_detector(name).fit(at_rate(lowest - 1))
