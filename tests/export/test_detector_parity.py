"""Every detector in C finds the same contacts as in Python, also with lost samples."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import building
import numpy as np
import pytest
from numpy.typing import NDArray

from firstcontact.chain import EventKind
from firstcontact.contact import DETECTORS, Detector, contact_chain, make_detector
from firstcontact.core import FINGERTIP_RATE, Block, Dataset, InputError, Pinch
from firstcontact.export import NamedModel, Trained
from firstcontact.export import _c_library as c_library
from firstcontact.models import Task, make_estimator
from firstcontact.testing._closings import closing
from firstcontact.testing._windows import toy_windows

Contacts = list[tuple[int, int, int]]


def trained(name: str, rate: float = FINGERTIP_RATE) -> Detector:
    pinches = tuple(at_rate(closing(seed), rate) for seed in range(24))
    return make_detector(name).fit(Dataset(pinches))


def at_rate(pinch: Pinch, rate: float) -> Pinch:
    """Return the same samples with another sampling rate."""
    return replace(pinch, layout=replace(pinch.layout, rate=rate))


def python_finds(detector: Detector, pinch: Pinch, volts: NDArray[np.float64]) -> Contacts:
    channels = tuple(replace(c, scale=1.0, offset=0.0) for c in pinch.layout.vibration)
    layout = replace(pinch.layout, channels=channels)
    chain = contact_chain(detector, layout, keeps_first_state=True)
    events = chain.take(Block(volts, 0))
    return [(e.channel, e.sample, e.known) for e in events if e.kind == EventKind.CONTACT_FOUND]


def spoilt(volts: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Yield variants of a signal: unchanged, with NaN, with a dead channel, saturated."""
    lost, dead, ended = volts.copy(), volts.copy(), volts.copy()
    lost[len(lost) // 3, 0] = np.nan
    lost[-40, 1] = np.inf
    dead[:, 1] = 0.25
    ended = np.clip(ended, -np.ptp(volts) / 8, np.ptp(volts) / 8)
    return [volts, lost, dead, ended]


@pytest.mark.parametrize("name", DETECTORS)
def test_c_finds_the_contacts_of_python(name: str, tmp_path: Path) -> None:
    detector = trained(name)
    library = tmp_path / "library"
    library.mkdir()
    try:
        c_library.write(Trained(detector=detector), library)
    except InputError as error:
        pytest.skip(f"{name}: {error}")
    requests, wanted = [], []
    for seed in range(100, 112):
        pinch = closing(seed)
        columns = pinch.layout.physical(pinch.data, (0, 1))
        for volts in spoilt(np.ascontiguousarray(columns, np.float64)):
            requests.append(volts)
            wanted.append(python_finds(detector, pinch, volts))
    built = building.Program("closings.c", library / "src", {})
    data = building.closings(requests)
    native = building.ask_native(built.native(tmp_path / "native", strict=True), data, tmp_path)
    assert building.contacts(native) == wanted
    assert any(wanted)
    if building.has_emulator():
        m7 = building.ask_m7(built.m7(tmp_path / "m7.elf"), data, tmp_path)
        assert building.contacts(m7) == wanted


#: Detectors and rates of the fast tests.
FEW = (("three_sigma", 8000.0), ("logistic", 2500.0))


def of_rate(rate: float) -> NamedModel:
    """Return a model that was trained at a rate."""
    X, y, groups = toy_windows()
    estimator = make_estimator("train_mean", Task.REGRESSION, rate)
    return NamedModel("stiffness", estimator.fit(X, y, groups, seed=1), None)


@pytest.mark.parametrize(
    ("name", "rate"),
    [
        pytest.param(name, rate, marks=[] if (name, rate) in FEW else [pytest.mark.slow])
        for name in DETECTORS
        for rate in (2500.0, 8000.0)
    ],
)
def test_so_it_does_at_other_rates(name: str, rate: float, tmp_path: Path) -> None:
    """At these rates a step of the detector is one or three samples.

    A detector without a rate of its own takes that of the models.
    """
    detector = trained(name, rate)
    text = c_library.write(Trained((of_rate(rate),), detector), tmp_path)
    assert text[-1].endswith(f", for {rate:g} Hz")
    pinches = [at_rate(closing(seed), rate) for seed in range(100, 112)]
    requests = [
        np.ascontiguousarray(p.layout.physical(p.data, (0, 1)), np.float64) for p in pinches
    ]
    wanted = [python_finds(detector, p, v) for p, v in zip(pinches, requests, strict=True)]
    native = building.Program("closings.c", tmp_path / "src", {}).native(tmp_path / "native", True)
    answered = building.ask_native(native, building.closings(requests), tmp_path)
    assert building.contacts(answered) == wanted
    assert any(wanted)


def test_a_detector_says_what_it_costs_at_its_top(tmp_path: Path) -> None:
    c_library.write(Trained(detector=trained(DETECTORS.default)), tmp_path)
    top = (tmp_path / "src" / "fc_detector_sizes.h").read_text(encoding="utf-8")[:400]
    assert "static memory about" in top
    assert not (tmp_path / "src" / "fc_model.c").exists()
