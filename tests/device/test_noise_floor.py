import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import (
    Block,
    Channel,
    ChannelKind,
    Finger,
    InputError,
    Layout,
    fingertip_layout,
)
from firstcontact.device import Arrival, Descriptor, measure_noise
from firstcontact.device._noise_floor import RestMeter

LAYOUT = fingertip_layout()
RATE = round(LAYOUT.rate)
VOLT = LAYOUT.channels[0].scale
ZERO = LAYOUT.channels[0].offset


def still(seconds: float, noise=(0.002, 0.004), offset=(0.01, -0.02), seed: int = 0):
    """Return raw samples of a hand at rest. Noise and offset of each piezo are in V."""
    n = round(seconds * LAYOUT.rate)
    data = np.zeros((n, 16), np.int16)
    rng = np.random.default_rng(seed)
    volts = np.array(offset) + np.array(noise) * rng.standard_normal((n, 2))
    data[:, :2] = np.rint(volts / VOLT + ZERO)
    data[:, 2:14] = 3000
    return data


class Samples:
    """Source of given samples, which then sends no more."""

    name = "a port"

    def __init__(self, data, layout=LAYOUT, length=37):
        self.descriptor = Descriptor(layout)
        self._left = [
            Arrival(Block(data[k : k + length], k), 0.0) for k in range(0, len(data), length)
        ]

    def read(self, timeout):
        taken, self._left = self._left[:10], self._left[10:]
        return taken


@given(
    st.tuples(st.floats(0.001, 0.02), st.floats(0.001, 0.02)),
    st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1)),
    st.integers(0, 1000),
)
def test_noise_and_offset_are_those_that_are_there(noise, offset, seed):
    calibration = measure_noise(Samples(still(2.2, noise, offset, seed)))
    for finger in Finger:
        piezo = next(p for p in calibration.piezo if p.finger is finger)
        assert piezo.noise == pytest.approx(noise[finger], rel=0.05, abs=0.3 * VOLT)
        assert piezo.offset == pytest.approx(offset[finger], abs=0.1 * noise[finger] + VOLT)
    assert calibration.created


def spoilt(fault: str):
    """Return more than two seconds of samples in which one finger is not at rest."""
    data = still(20)
    if fault == "strip":
        data[:, 15] = 1
    elif fault == "force":
        data[:, 3] = 20_000
    elif fault == "rising force":
        data[:, 9] = np.minimum(3000 + 3 * np.arange(len(data)), 30_000)
    elif fault == "piezo":
        loud = np.arange(len(data)) // RATE % 2 == 1
        data[loud, 0] += np.rint(300 * np.sin(np.arange(loud.sum()))).astype(np.int16)
    elif fault == "flat":
        data[:, 1] = 16_384
    return data


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("strip", "the thumb's strip"),
        ("force", "the index's force"),
        ("rising force", "the thumb's force"),
        ("piezo", "the index's piezo"),
        ("flat", "the thumb's piezo"),
    ],
)
def test_it_is_refused_while_something_touches_and_says_which_finger(fault, said):
    with pytest.raises(InputError, match=said) as refused:
        measure_noise(Samples(spoilt(fault)), seconds=2.0, patience=0.0)
    other = "index" if "thumb" in said else "thumb"
    assert f"the {other}" not in str(refused.value)


def test_a_sensor_of_no_finger_is_refused_without_words_of_a_hand():
    disc = Channel("disc", ChannelKind.VIBRATION, None, "V")
    loud = np.arange(20 * RATE) // RATE % 2 == 1
    noise = np.random.default_rng(0).standard_normal(20 * RATE) * np.where(loud, 1.0, 0.01)
    source = Samples(noise[:, None], Layout((disc,), LAYOUT.rate))
    with pytest.raises(InputError, match="the piezo") as refused:
        measure_noise(source, seconds=2.0, patience=0.0)
    assert not {"hand", "motor", "sensor's"} & set(str(refused.value).split())


def test_a_hand_that_closes_is_measured_between_its_closings():
    data = still(12)
    for start in range(RATE, len(data), 2 * RATE):
        closing = slice(start, start + RATE)
        data[closing, :2] += np.random.default_rng(start).normal(0, 400, (len(data[closing]), 2)
            ).astype(np.int16)  # fmt: skip
        data[closing, 14:] = 1
    calibration = measure_noise(Samples(data), seconds=2.0, patience=10.0)
    assert calibration.noise(Finger.INDEX) == pytest.approx(0.002, rel=0.05)
    assert calibration.noise(Finger.THUMB) == pytest.approx(0.004, rel=0.05)


def test_a_source_that_falls_silent_is_told():
    with pytest.raises(InputError, match="a port"):
        measure_noise(Samples(still(0.5)), seconds=2.0)


def test_no_part_reaches_across_a_gap():
    meter = RestMeter(LAYOUT, 1.0)
    data = still(4)
    data[2 * RATE :, :2] += 1000  # as if the offset had moved while nothing came
    meter.update(Block(data[: 2 * RATE + 0], 0))
    meter.update(Block(data[2 * RATE :], 2 * RATE + 500))
    assert meter.calibration().noise(Finger.INDEX) == pytest.approx(0.002, rel=0.05)


def test_a_layout_without_a_vibration_channel_is_refused():
    with pytest.raises(InputError, match="no vibration channel"):
        RestMeter(Layout(LAYOUT.channels[14:], LAYOUT.rate))
