import numpy as np
import pytest
from memory_source import CALIBRATION, FLOOR, LAYOUT, RATE, MemorySource, arrivals

from firstcontact.collect import tap_warnings, wait_for_tap
from firstcontact.collect._calibrate import TapWatch
from firstcontact.core import Block, Calibration, Finger, InputError, VibrationCalibration


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


@pytest.mark.parametrize("length", [1, 50, 20_000])
@pytest.mark.parametrize("finger", Finger)
def test_watch_returns_the_peak_of_a_tap(length, finger):
    watch = TapWatch(LAYOUT, CALIBRATION, finger)
    data = tap_signal(0.8, finger)
    peaks = [watch.update(Block(data[k : k + length], k)) for k in range(0, len(data), length)]
    assert next(p for p in peaks if p is not None) == pytest.approx(0.8, abs=1e-3)


def test_tap_updates_the_calibration_of_its_finger():
    calibration = wait_for_tap(MemorySource(arrivals(tap_signal(0.5))), CALIBRATION, Finger.THUMB)
    assert [p.tap for p in calibration.piezo] == [None, pytest.approx(0.5, abs=1e-3)]
    assert calibration.noise(Finger.THUMB) == FLOOR


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


def test_source_without_samples_is_refused():
    with pytest.raises(InputError, match=MemorySource.name):
        wait_for_tap(MemorySource(), CALIBRATION, Finger.THUMB)


@pytest.mark.parametrize(
    ("taps", "problems"),
    [
        ((0.5, 0.6), []),
        ((None, None), []),
        ((0.05, 0.06), ["the index's tap gave only", "the thumb's tap gave only"]),
        ((0.3, 1.2), ["the thumb's tap was 4.0 times as loud"]),
    ],
)
def test_weak_or_unequal_taps_raise_a_warning(taps, problems):
    piezo = tuple(VibrationCalibration(f, FLOOR, 0.0, t) for f, t in zip(Finger, taps, strict=True))
    warnings = tap_warnings(Calibration(piezo))
    assert len(warnings) == len(problems)
    assert all(part in sentence for part, sentence in zip(problems, warnings, strict=True))


def test_tap_of_a_sensor_without_a_finger_has_no_warning():
    piezo = (VibrationCalibration(None, FLOOR, 0.0, 0.05),)
    assert not tap_warnings(Calibration(piezo))
