"""Loaded detectors equal the saved ones. Damaged and foreign files are refused."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from safetensors.numpy import load_file, save

from firstcontact.cli.main import main
from firstcontact.contact import (
    Detector,
    SvmDetector,
    detect,
    general_detector,
    load_detector,
    save_detector,
)
from firstcontact.contact.detector_file import is_pretrained, pretrained_detector
from firstcontact.core import InputError, fingertip_layout
from firstcontact.testing import closings
from saved import edit, vouch

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
