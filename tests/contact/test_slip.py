"""Slip detector: slips, other sounds, and independence of the block sizes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.io import loadmat

from firstcontact.contact import SLIP_DETECTORS
from firstcontact.contact.slip import AGAIN
from firstcontact.core import Block, fingertip_layout

LAYOUT = fingertip_layout()
RATE = LAYOUT.rate
SECONDS = 1.0
BEGIN = round(0.6 * RATE)


def stream(rubs: float = 0.0, knock: float = 0.0, begin: int = BEGIN) -> NDArray[np.int16]:
    """Return the noise of a quiet hold with rubbing from one sample on, or a 2 ms knock, in V."""
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
def test_slip_raises_an_alarm_soon_and_repeats_it(name: str) -> None:
    alarm_samples = alarms(stream(rubs=0.03), name=name)
    assert BEGIN < alarm_samples[0] < BEGIN + 0.015 * RATE
    gaps = np.diff(alarm_samples) / RATE
    assert (gaps >= 0.95 * AGAIN).all()
    assert len(alarm_samples) >= 0.8 * (SECONDS - 0.6) / AGAIN


@pytest.mark.parametrize("name", SLIP_DETECTORS)
def test_rest_and_a_knock_raise_no_alarm(name: str) -> None:
    assert alarms(stream(), name=name) == []
    assert alarms(stream(knock=0.5), name=name) == []


def test_alarms_are_causal_for_any_block_size() -> None:
    data = stream(rubs=0.03)
    alarm_samples = alarms(data)
    assert alarm_samples == alarms(data, 1) == alarms(data, 997)
    changed = data.copy()
    changed[alarm_samples[0] + 1 :] = 512
    assert alarms(changed)[:1] == alarm_samples[:1]


def test_no_alarm_before_the_noise_estimate_or_without_an_object() -> None:
    early_slip = stream(rubs=0.03, begin=0)
    assert alarms(early_slip) == [], "it counts as the rest"
    detector = SLIP_DETECTORS["power"]()
    detector.start(LAYOUT)
    assert detector.update(Block(stream(rubs=0.03), 0)) == []
    detector.hold()
    detector.release()
    assert detector.update(Block(stream(rubs=0.03), len(stream()))) == []


def test_gap_restarts_the_noise_estimate() -> None:
    data = stream(rubs=0.03)
    detector = SLIP_DETECTORS["power"]()
    detector.start(LAYOUT)
    detector.hold()
    assert detector.update(Block(data[: BEGIN - 50], 0)) == []
    assert detector.update(Block(data[BEGIN + 50 :], BEGIN + 50)) == []


def test_real_holds_of_another_sensor_raise_few_alarms(biotac: Path) -> None:
    """The threshold was set on the twin. No slip is labelled in the ten minutes of holds."""
    layout = replace(LAYOUT, rate=2200.0)
    count, samples = 0, 0
    for file in sorted(biotac.rglob("*.mat")):
        hold = loadmat(file)
        data = np.zeros((hold["F0pac"].size, layout.width), np.int16)
        for column, name in enumerate(("F0pac", "F1pac")):
            data[:, column] = hold[name].flatten("F")
        detector = SLIP_DETECTORS["power"]()
        detector.start(layout)
        detector.hold()
        count += len(detector.update(Block(data, 0)))
        samples += len(data)
    assert samples / layout.rate > 500
    assert count / (samples / layout.rate / 60) <= 1.0
