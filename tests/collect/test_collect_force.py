"""Tests of calibration by a person: force curves and taps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from memory_source import CALIBRATION, FLOOR, LAYOUT, RATE, UNLOADED, MemorySource, arrivals

from firstcontact.collect.calibration import (
    Weighing,
    fit_force,
    loaded_volts,
    read_weights,
    tap_warnings,
    wait_for_tap,
)
from firstcontact.core import Calibration, Finger, InputError, VibrationCalibration
from firstcontact.core.board import DIVIDER_OHM

NEWTONS = np.array([0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0])


def volts(force, leak, gain, exponent):
    """Return the voltage over the divider for a sheet with this curve, V."""
    g = leak + gain * np.asarray(force) ** exponent
    return 3.3 * DIVIDER_OHM * g / (1 + DIVIDER_OHM * g)


def weigh(newtons, readings, finger=Finger.INDEX):
    return [Weighing(finger, f, v) for f, v in zip(newtons, readings, strict=True)]


leaks, gains, exponents = st.floats(2e-6, 5e-5), st.floats(3e-5, 3e-4), st.floats(0.5, 1.2)


@given(leaks, gains, exponents, st.sampled_from(Finger))
def test_fit_recovers_a_curve_without_noise(leak, gain, exponent, finger):
    readings = volts(NEWTONS, leak, gain, exponent)
    curve = fit_force(weigh(NEWTONS, readings, finger))
    assert curve.finger is finger
    assert curve.leak == pytest.approx(leak, rel=1e-2, abs=1e-8)
    assert curve.gain == pytest.approx(gain, rel=1e-3)
    assert curve.exponent == pytest.approx(exponent, rel=1e-3)
    between = np.array([0.3, 0.7, 3.0, 8.0])
    forces = curve.newtons(volts(between, leak, gain, exponent))
    assert forces == pytest.approx(between, rel=1e-2)
    assert curve.rms < 0.02


@given(st.integers(0, 10_000))
def test_converter_noise_changes_the_fit_little(seed):
    # A count of the converter is 3.2 mV.
    readings = volts(NEWTONS, 2e-5, 8e-5, 0.8) + np.random.default_rng(seed).normal(0, 0.003, 7)
    curve = fit_force(weigh(NEWTONS, readings))
    between = np.array([0.5, 1.0, 3.0, 5.0])
    assert curve.newtons(volts(between, 2e-5, 8e-5, 0.8)) == pytest.approx(between, rel=0.1)


@pytest.mark.parametrize(
    ("weighings", "problem"),
    [
        ([], "0 different"),
        (weigh([1, 2, 3], [0.5, 1.0, 1.5]), "3 different"),
        (weigh([0, 1, 2, 1e200], [0.2, 0.5, 1.0, 1.5]), "from 0 to 1000"),
        (weigh([1, 1, 1, 1, 2], [0.5, 0.5, 0.6, 0.5, 1.0]), "2 different"),
        (weigh([0, 1, 2, 3], [0.3, 1.0, 0.9, 1.5]), "2 N .* 1 N"),
        (weigh([-1, 1, 2, 3], [0.3, 1.0, 1.2, 1.5]), "from 0 to"),
        (weigh([0, 1, 2, 3], [0.3, 1.0, 1.2, 3.3]), "between 0 and 3.3"),
        (weigh([0, 1, 2, 3], [0.0, 1.0, 1.2, 1.5]), "between 0 and 3.3"),
    ],
)
def test_weights_without_a_curve_are_refused(weighings, problem):
    with pytest.raises(InputError, match=problem):
        fit_force(weighings)


def test_weights_are_read_from_a_file(tmp_path):
    path = tmp_path / "weights.csv"
    path.write_text("finger,newtons,volts\nindex,0,0.3\nThumb, 1.5, 1.25\n")
    assert read_weights(path) == (
        Weighing(Finger.INDEX, 0.0, 0.3),
        Weighing(Finger.THUMB, 1.5, 1.25),
    )
    path.write_text("finger,newtons\nindex,0\n")
    with pytest.raises(InputError, match="'volts'"):
        read_weights(path)
    path.write_text("finger,newtons,volts\nring,0,0.3\n")
    with pytest.raises(InputError, match="line 2"):
        read_weights(path)


def test_the_most_loaded_taxel_is_weighed():
    data = np.zeros((10_000, 16), np.int16)
    data[:, 2:14] = UNLOADED
    data[:, 10] = 12_000
    scale = LAYOUT.channels[10].scale
    early = np.full((1000, 16), 13_000, np.int16)  # waits to be read: 20 arrivals of 50 samples
    source = MemorySource(arrivals(np.concatenate([early, data])))
    assert loaded_volts(source, Finger.THUMB) == pytest.approx(12_000 * scale)
    assert loaded_volts(source, Finger.INDEX, 0.5) == pytest.approx(UNLOADED * scale)
    with pytest.raises(InputError, match=MemorySource.name):
        loaded_volts(source, Finger.INDEX)


def tap_signal(peak: float, finger: Finger = Finger.THUMB, seconds: float = 2.0) -> np.ndarray:
    """Return a signal at rest with one tap on one finger after a second. Its peak is in V."""
    n = round(seconds * RATE)
    volts = np.random.default_rng(0).normal(0, FLOOR / 2, (n, 2))
    t = np.arange(n - round(RATE)) / RATE
    volts[round(RATE) :, finger] = peak * np.exp(-t / 0.02) * np.cos(2 * np.pi * 200 * t)
    data = np.zeros((n, 16), np.int16)
    piezo = LAYOUT.channels[0]
    data[:, :2] = np.rint(volts / piezo.scale + piezo.offset)
    return data


@pytest.mark.parametrize("length", [1, 50])
@pytest.mark.parametrize("finger", Finger)
def test_tap_updates_the_calibration_of_its_finger(length, finger):
    source = MemorySource(arrivals(tap_signal(0.8, finger), length))
    calibration = wait_for_tap(source, CALIBRATION, finger)
    taps = {p.finger: p.tap for p in calibration.piezo}
    assert taps.pop(finger) == pytest.approx(0.8, abs=1e-3)
    assert set(taps.values()) == {None}
    assert calibration.noise(finger) == FLOOR


def test_tap_on_the_other_finger_is_ignored():
    source = MemorySource(arrivals(tap_signal(0.5, Finger.INDEX, seconds=4)))
    with pytest.raises(InputError, match="thumb") as error:
        wait_for_tap(source, CALIBRATION, Finger.THUMB, patience=3.0)
    assert error.value.parameter == "tap"


def test_tap_before_the_request_is_ignored():
    early = tap_signal(1.2)[round(RATE) - 100 :][:1000]  # waits to be read
    source = MemorySource(arrivals(np.concatenate([early, tap_signal(0.5)])))
    calibration = wait_for_tap(source, CALIBRATION, Finger.THUMB)
    assert [p.tap for p in calibration.piezo] == [None, pytest.approx(0.5, abs=1e-3)]


@pytest.mark.parametrize(
    ("taps", "problems"),
    [
        ((0.5, 0.6), []),
        ((None, None), []),
        ((0.05, 0.06), ["index finger", "thumb"]),
        ((0.3, 1.2), ["thumb was 4.0 times"]),
    ],
)
def test_weak_or_unequal_taps_raise_a_warning(taps, problems):
    piezo = tuple(VibrationCalibration(f, FLOOR, 0.0, t) for f, t in zip(Finger, taps, strict=True))
    warnings = tap_warnings(Calibration(piezo))
    assert len(warnings) == len(problems)
    assert all(part in sentence for part, sentence in zip(problems, warnings, strict=True))
