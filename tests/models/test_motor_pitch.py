"""Closing speed from the pitch of the motor."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firstcontact.chain.touch import touch_constants
from firstcontact.core.layout import FINGERTIP_RATE as RATE
from firstcontact.models import Touches
from firstcontact.models.rig.rigs import STEP, MotorPitch, spectra
from firstcontact.signal import samples_in

BEFORE_SAMPLES = samples_in(Touches.BEFORE, RATE)
#: Largest shift of the search, points: a factor of two in speed.
FARTHEST = 88
WIDTH = BEFORE_SAMPLES + samples_in(Touches.LONGEST, RATE)


def motor(ratios: np.ndarray, seed: int, rotor: float = 170.0, noise: float = 0.003) -> np.ndarray:
    """Return signals of rotor and gears, V, at these relative speeds, with noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(WIDTH) / RATE
    lines = [(k * rotor, 0.02 / k) for k in (1, 2, 3)] + [(5.3 * rotor, 0.01)]
    out = noise * rng.standard_normal((len(ratios), WIDTH))
    for f, a in lines:
        phase = rng.uniform(0, 2 * np.pi, (len(ratios), 1))
        out += a * np.sin(2 * np.pi * f * ratios[:, None] * t + phase)
    return out.astype(np.float32)


def heard(signals: np.ndarray) -> np.ndarray:
    return spectra(signals, RATE)


@settings(max_examples=15)
@given(st.integers(0, 1000), st.floats(150.0, 260.0), st.floats(0.01, 0.15))
def test_the_ratio_of_speeds_is_heard_within_two_per_cent(
    seed: int, rotor: float, spread: float
) -> None:
    rng = np.random.default_rng(seed)
    own_values = np.exp(spread * rng.standard_normal(30))
    pitch = MotorPitch.fit(heard(motor(own_values, seed, rotor)))
    requests = np.linspace(0.8, 1.25, 9)
    speed, alike = pitch.listen(heard(motor(requests, seed + 1, rotor)))
    assert (alike > touch_constants().believed).all()
    assert np.exp(speed) * np.median(own_values) == pytest.approx(requests, rel=0.02)


def test_it_is_heard_at_any_gain() -> None:
    ratios = np.linspace(0.9, 1.1, 20)
    signals = motor(ratios, 3)
    first, loud = (
        MotorPitch.fit(heard(g * signals)).listen(heard(g * signals))[0] for g in (1, 30)
    )
    assert first == pytest.approx(loud, abs=2 * STEP)


def test_what_comes_from_the_contact_on_is_not_heard() -> None:
    signals = motor(np.ones(5), 1)
    louder = signals.copy()
    louder[:, BEFORE_SAMPLES:] = 10.0
    assert np.array_equal(heard(signals), heard(louder))


def test_noise_is_not_believed() -> None:
    pitch = MotorPitch.fit(heard(motor(np.exp(np.linspace(-0.1, 0.1, 20)), 2)))
    rng = np.random.default_rng(5)
    silent = (0.003 * rng.standard_normal((40, WIDTH))).astype(np.float32)
    assert np.mean(pitch.listen(heard(silent))[1] > touch_constants().believed) < 0.1


def test_silence_and_shifts_beyond_what_is_looked_for_stay_finite() -> None:
    pitch = MotorPitch.fit(heard(motor(np.ones(4), 0)))
    for signals in (np.zeros((3, WIDTH), np.float32), motor(np.full(3, 2.7), 1)):
        speed, alike = pitch.listen(heard(signals))
        assert (np.abs(speed) <= 2 * FARTHEST * STEP).all()
        assert ((alike >= 0) & (alike <= 1)).all()
