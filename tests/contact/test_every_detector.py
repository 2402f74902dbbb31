"""Detectors: conformance of all that are registered, files, and each kind against closed forms."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from safetensors.numpy import load_file, save

from firstcontact.cli.main import main
from firstcontact.contact import (
    DETECTORS,
    Detector,
    SvmDetector,
    ThresholdDetector,
    detect,
    general_detector,
    load_detector,
    make_detector,
    save_detector,
)
from firstcontact.contact.contacts import judge_windows
from firstcontact.contact.detector_file import is_pretrained, pretrained_detector
from firstcontact.contact.svm import WIDTH, RbfMachine
from firstcontact.core import Block, Dataset, InputError, Pinch, fingertip_layout
from firstcontact.signal import samples_in
from firstcontact.testing import check_detector, closings
from firstcontact.testing.synthetic import LAYOUT, closing
from saved import edit, vouch

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


CARD, DETECTOR_WEIGHTS = "detector.json", "detector.safetensors"
FRESH = closings(8, seed=7).pinches


@pytest.fixture
def svm(fitted: dict[str, Detector]) -> SvmDetector:
    detector = fitted["svm"]
    assert isinstance(detector, SvmDetector)
    return detector


@pytest.fixture
def folder(svm: SvmDetector, tmp_path: Path) -> Path:
    return save_detector(svm, tmp_path / "mödel", {"pinches": 3})


def test_loaded_detector_finds_the_same_contacts(detector: Detector, tmp_path: Path) -> None:
    """The fixture goes through all registered detectors."""
    loaded = load_detector(save_detector(detector, tmp_path))
    assert loaded.name == detector.name
    contacts = [detect(detector, pinch) for pinch in FRESH]
    assert [detect(loaded, pinch) for pinch in FRESH] == contacts
    assert any(contacts)


def test_untrained_detector_is_not_saved(tmp_path: Path) -> None:
    with pytest.raises(InputError):
        save_detector(SvmDetector(), tmp_path / "m")
    assert not (tmp_path / "m").exists()


@pytest.mark.parametrize(
    "changes",
    [
        {"format": "firstcontact-model"},
        {"name": "ear"},
        {"rate_hz": 1000.0},
        {"sha256": None},
        {"name": "three_sigma"},
    ],
    ids=str,
)
def test_invalid_card_is_refused(folder: Path, changes: dict[str, Any]) -> None:
    edit(folder, CARD, **changes)
    with pytest.raises(InputError) as caught:
        load_detector(folder)
    assert str(folder) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_decision_that_is_not_finite_is_refused(folder: Path) -> None:
    arrays = load_file(folder / DETECTOR_WEIGHTS)
    for name in ("weights", "support"):
        vouch(
            folder, save(arrays | {name: np.full_like(arrays[name], 1e308)}), CARD, DETECTOR_WEIGHTS
        )
        with pytest.raises(InputError):
            detect(load_detector(folder), FRESH[0])


@pytest.mark.slow
def test_shipped_detector_is_reproducible(tmp_path: Path) -> None:
    """The test runs the commands of docs/how-to/adapt-to-your-rig.md."""
    numbers = ["--pinches-per-block", "60", "--pinches-per-object", "30", "--seed", "7"]
    twin, trained_folder = str(tmp_path / "twin"), str(tmp_path / "detector")
    assert main(["simulate", "--out", twin, "--condition", "everyday", *numbers]) == 0
    assert main(["train", twin, "--out", trained_folder, "--detector-only"]) == 0
    trained, shipped = (
        d.to_arrays() for d in (load_detector(trained_folder), pretrained_detector())
    )
    assert trained.keys() == shipped.keys()
    for name, array in trained.items():
        np.testing.assert_allclose(array, shipped[name], rtol=1e-6)


def test_general_detector_is_the_shipped_one_for_a_hand_at_its_rate() -> None:
    layout = fingertip_layout()
    assert is_pretrained(general_detector(layout))
    by_person = replace(layout, channels=(replace(layout.channels[0], finger=None),))
    for other in (by_person, replace(layout, rate=8000.0), replace(layout, rate=4935.9)):
        detector = general_detector(other)
        detector.chain_constants(other.rate)
        assert not detector.learns
        assert not is_pretrained(detector)


def test_detector_fitted_to_other_pinches_is_not_the_shipped_one(svm: SvmDetector) -> None:
    shipped = pretrained_detector()
    fitted = type(shipped)().fit(closings(40, seed=1))
    assert fitted.rate == shipped.rate
    assert not is_pretrained(fitted)
    assert not is_pretrained(svm)


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


BEFORE, STEP = 197, 15


def stream(height: float, position: int) -> Block:
    """Return a square wave of known sigma with one sample of another height."""
    x = np.tile([1.0, -1.0], 300) * 320
    x[position] = height * 320
    data = np.full((600, 16), 16384.0)
    data[:, 0] += x
    return Block(data)


@pytest.mark.parametrize(("height", "fires"), [(2.9, False), (3.1, True), (-3.1, True)])
def test_fires_above_three_sigmas(height, fires):
    verdicts = judge_windows(ThresholdDetector(), LAYOUT, stream(height, 400))
    assert verdicts.fired.any() == fires


def test_a_contact_is_placed_in_its_window_however_short_its_steps_are():
    class Short(ThresholdDetector):
        name = "short"
        step, reach = 0.0002, 1

    verdicts = judge_windows(Short(), LAYOUT, stream(10.0, 400))
    assert verdicts.fired.any()
    assert np.abs(verdicts.onsets[verdicts.fired] - 400).max() <= 3


def test_crossing_fires_in_one_window():
    verdicts = judge_windows(ThresholdDetector(), LAYOUT, stream(10.0, 400))
    row = (400 - BEFORE) // STEP
    assert np.argwhere(verdicts.fired).tolist() == [[row, 0]]
    assert verdicts.ends[row] - STEP < 400 <= verdicts.ends[row]
