import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Block, Finger, InputError, fingertip_layout
from firstcontact.device import Arrival, Descriptor
from firstcontact.device.noise_floor import RestMeter, measure_noise

LAYOUT = fingertip_layout()
RATE = round(LAYOUT.rate)
VOLT = LAYOUT.channels[0].scale
ZERO = LAYOUT.channels[0].offset


def rest_signal(seconds: float, noise=(0.002, 0.004), offset=(0.01, -0.02), seed: int = 0):
    """Return raw samples of a hand at rest. Noise and offset of each piezo are in V."""
    n = round(seconds * LAYOUT.rate)
    data = np.zeros((n, 16), np.int16)
    rng = np.random.default_rng(seed)
    volts = np.array(offset) + np.array(noise) * rng.standard_normal((n, 2))
    data[:, :2] = np.rint(volts / VOLT + ZERO)
    data[:, 2:14] = 3000
    return data


class Samples:
    """Source that sends given samples, and nothing after them."""

    name = "a port"
    ended = False

    def __init__(self, data, layout=LAYOUT, length=37):
        self.descriptor = Descriptor(layout)
        self._left = [
            Arrival(Block(data[k : k + length], k), 0.0) for k in range(0, len(data), length)
        ]

    def read(self, timeout):
        arrivals, self._left = self._left[:10], self._left[10:]
        return arrivals


@given(
    st.tuples(st.floats(0.001, 0.02), st.floats(0.001, 0.02)),
    st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1)),
    st.integers(0, 1000),
)
def test_measured_noise_and_offset_match_the_signal(noise, offset, seed):
    calibration = measure_noise(Samples(rest_signal(2.2, noise, offset, seed)))
    for finger in Finger:
        piezo = next(p for p in calibration.piezo if p.finger is finger)
        assert piezo.noise == pytest.approx(noise[finger], rel=0.05, abs=0.3 * VOLT)
        assert piezo.offset == pytest.approx(offset[finger], abs=0.1 * noise[finger] + VOLT)
    assert calibration.created


def disturbed_signal(fault: str):
    """Return more than two seconds of samples in which one finger is not at rest."""
    data = rest_signal(20)
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
    ("fault", "sensor_name"),
    [
        ("strip", "the thumb's strip"),
        ("force", "the index's force"),
        ("rising force", "the thumb's force"),
        ("piezo", "the index's piezo"),
        ("flat", "the thumb's piezo"),
    ],
)
def test_touched_finger_is_refused_by_name(fault, sensor_name):
    with pytest.raises(InputError, match=sensor_name) as error:
        measure_noise(Samples(disturbed_signal(fault)), seconds=2.0, patience=0.0)
    other_finger = "index" if "thumb" in sensor_name else "thumb"
    assert f"the {other_finger}" not in str(error.value)


def test_noise_is_measured_between_closings():
    data = rest_signal(12)
    for start in range(RATE, len(data), 2 * RATE):
        closing = slice(start, start + RATE)
        data[closing, :2] += np.random.default_rng(start).normal(0, 400, (len(data[closing]), 2)
            ).astype(np.int16)  # fmt: skip
        data[closing, 14:] = 1
    calibration = measure_noise(Samples(data), seconds=2.0, patience=10.0)
    assert calibration.noise(Finger.INDEX) == pytest.approx(0.002, rel=0.05)
    assert calibration.noise(Finger.THUMB) == pytest.approx(0.004, rel=0.05)


def test_silent_source_is_refused():
    with pytest.raises(InputError, match="a port"):
        measure_noise(Samples(rest_signal(0.5)), seconds=2.0)


def test_measured_parts_do_not_span_a_gap():
    meter = RestMeter(LAYOUT, 1.0)
    data = rest_signal(4)
    data[2 * RATE :, :2] += 1000  # as if the offset had moved while nothing came
    meter.update(Block(data[: 2 * RATE + 0], 0))
    meter.update(Block(data[2 * RATE :], 2 * RATE + 500))
    assert meter.calibration().noise(Finger.INDEX) == pytest.approx(0.002, rel=0.05)
