from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from firstcontact.core.installation import load_compiled
from firstcontact.twin.noise import (
    RUBBING,
    RUBBING_BAND,
    MotorNoise,
    electrical_noise,
    phalanx_force,
)

RATE = 19_744.0
QUIET = replace(MotorNoise(), rotor=0.0, mesh=0.0, friction=0.0, mains=0.0, click_rate=0.0)


def series(noise: MotorNoise, duration: float = 4.0, seed: int = 5) -> np.ndarray:
    return phalanx_force(noise, duration, np.random.default_rng(seed))


def level(x: np.ndarray, frequency: float) -> float:
    """Return the amplitude of a signal near a frequency."""
    f, p = signal.periodogram(x, RATE, "flattop", scaling="spectrum")
    near = np.abs(f - frequency) < 0.02 * frequency + 2
    return float(np.sqrt(2 * p[near].max()))


def test_zero_parameters_make_no_force() -> None:
    assert not series(QUIET).any()


def test_rotor_harmonics_have_the_frequency_of_the_speed() -> None:
    x = series(replace(QUIET, rotor=0.06, rotor_rate=150.0))
    assert level(x, 150) == pytest.approx(0.06, rel=0.05)
    assert level(x, 300) == pytest.approx(0.03, rel=0.05)
    assert level(x, 450) == pytest.approx(0.02, rel=0.05)


def test_the_band_of_rubbing_is_scipys() -> None:
    sections = signal.butter(2, RUBBING_BAND, "bandpass", fs=RATE, output="sos")
    np.testing.assert_allclose(RUBBING, sections, rtol=1e-12)
    white = np.random.default_rng(1).standard_normal(500)
    out = np.empty_like(white)
    load_compiled("firstcontact.twin._compiled").filtered(RUBBING, white, out)
    np.testing.assert_allclose(out, signal.sosfilt(sections, white), rtol=1e-8, atol=1e-10)


def test_rubbing_has_its_power_and_band() -> None:
    x = series(replace(QUIET, friction=0.04, wander=0.0))
    assert x.std() == pytest.approx(0.04, rel=0.1)
    f, p = signal.welch(x, RATE, nperseg=4096)
    assert p[(f > 100) & (f < 1000)].mean() > 20 * p[f > 5000].mean()


def test_clicks_have_their_rate() -> None:
    x = series(replace(QUIET, click_rate=2.0), duration=200.0)
    clicks = np.sum((x[1:] != 0) & (x[:-1] == 0))
    assert clicks == pytest.approx(400, abs=4 * 20)


@pytest.mark.parametrize("mains", [50.0, 60.0])
def test_mains_appears_as_torque_and_pickup(mains: float) -> None:
    noise = replace(QUIET, mains=0.02, mains_rate=mains, electronics=0.0)
    assert level(series(noise), 2 * mains) == pytest.approx(0.02, rel=0.05)
    angle = 2 * np.pi * mains * np.arange(round(4 * RATE)) / RATE
    hum, sheet = electrical_noise(noise, 0.004, angle, np.random.default_rng(1))
    assert level(hum, mains) == pytest.approx(noise.hum, rel=0.05)
    assert sheet.std() == pytest.approx(0.004, rel=0.02)
