"""A slip detector: what is a slip, what is none, and that blocks do not matter."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.io import loadmat

from firstcontact.contact import SLIP_DETECTORS, PowerSlipDetector
from firstcontact.contact._slip import AGAIN
from firstcontact.core import ADC_COUNTS, ADC_VOLTS, Block, fingertip_layout

LAYOUT = fingertip_layout()
RATE = LAYOUT.rate
SECONDS = 1.0
BEGIN = round(0.6 * RATE)


def stream(rubs: float = 0.0, knock: float = 0.0, begin: int = BEGIN) -> NDArray[np.int16]:
    """Noise of a quiet hold, and from a sample on rubbing, or a knock of 2 ms, both in V."""
    rng = np.random.default_rng(0)
    n = round(SECONDS * RATE)
    volts = 0.01 * rng.standard_normal((n, 2))
    volts[begin:] += rubs * rng.standard_normal((n - begin, 2))
    volts[begin : begin + 10] += knock * rng.standard_normal((10, 2))
    data = np.zeros((n, LAYOUT.width), np.int16)
    scale = np.array([c.scale for c in LAYOUT.column_channels[:2]])
    offset = np.array([c.offset for c in LAYOUT.column_channels[:2]])
    data[:, :2] = np.round(volts / scale + offset)
    return data


def alarms(data: NDArray[np.int16], size: int = 25, name: str = "power") -> list[int]:
    detector = SLIP_DETECTORS[name]()
    detector.start(LAYOUT)
    detector.hold()
    return [
        a for i in range(0, len(data), size) for a in detector.update(Block(data[i : i + size], i))
    ]


@pytest.mark.parametrize("name", SLIP_DETECTORS)
def test_a_slip_is_heard_soon_and_told_again_while_it_goes_on(name: str) -> None:
    found = alarms(stream(rubs=0.03), name=name)
    assert BEGIN < found[0] < BEGIN + 0.015 * RATE
    gaps = np.diff(found) / RATE
    assert (gaps >= 0.95 * AGAIN).all()
    assert len(found) >= 0.8 * (SECONDS - 0.6) / AGAIN


@pytest.mark.parametrize("name", SLIP_DETECTORS)
def test_rest_and_a_knock_are_no_slip(name: str) -> None:
    assert alarms(stream(), name=name) == []
    assert alarms(stream(knock=0.5), name=name) == []


def test_blocks_do_not_matter_and_nothing_is_seen_before_it_comes() -> None:
    data = stream(rubs=0.03)
    found = alarms(data)
    assert found == alarms(data, 1) == alarms(data, 997)
    changed = data.copy()
    changed[found[0] + 1 :] = 512
    assert alarms(changed)[:1] == found[:1]


def test_nothing_is_a_slip_before_the_rest_is_known_or_where_nothing_is_held() -> None:
    from_the_first = stream(rubs=0.03, begin=0)
    assert alarms(from_the_first) == [], "it is taken for the rest"
    detector = PowerSlipDetector()
    detector.start(LAYOUT)
    assert detector.update(Block(stream(rubs=0.03), 0)) == []
    detector.hold()
    detector.release()
    assert detector.update(Block(stream(rubs=0.03), len(stream()))) == []


def test_a_gap_has_the_rest_learned_anew() -> None:
    data = stream(rubs=0.03)
    detector = PowerSlipDetector()
    detector.start(LAYOUT)
    detector.hold()
    assert detector.update(Block(data[: BEGIN - 50], 0)) == []
    assert detector.update(Block(data[BEGIN + 50 :], BEGIN + 50)) == []


def test_what_is_not_loud_enough_to_be_counted_is_not_heard() -> None:
    """One step of the converter is what a slip of a light thing stays below."""
    step = ADC_VOLTS / ADC_COUNTS
    assert alarms(stream(rubs=step)) == []


def test_real_holds_of_another_sensor_hardly_ever_slip(biotac: Path) -> None:
    """The threshold was set on a twin; ten minutes in which nothing is said to slip."""
    layout = replace(LAYOUT, rate=2200.0)
    found, samples = 0, 0
    for file in sorted(biotac.rglob("*.mat")):
        held = loadmat(file)
        data = np.zeros((held["F0pac"].size, layout.width), np.int16)
        for column, name in enumerate(("F0pac", "F1pac")):
            data[:, column] = held[name].flatten("F")
        detector = PowerSlipDetector()
        detector.start(layout)
        detector.hold()
        found += len(detector.update(Block(data, 0)))
        samples += len(data)
    assert samples / layout.rate > 500
    assert found / (samples / layout.rate / 60) <= 1.0
