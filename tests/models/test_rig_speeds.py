"""Closing speeds: measured ones, and those from the pitch of the motor."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firstcontact.chain.touch import HINTS, touch_constants
from firstcontact.core import InputError
from firstcontact.core.layout import FINGERTIP_RATE as RATE
from firstcontact.models import Touches
from firstcontact.models.model_file import pretrained
from firstcontact.models.rig.rig_model import RigModel
from firstcontact.models.rig.rigs import STEP, MotorPitch, Rig, RigSpeeds, spectra
from firstcontact.signal import samples_in
from ringing import ringing

KNOWN, SHORE_A, _ = ringing(60)
NEVER = np.zeros(1, np.bool_)
NOTHING = np.zeros(1)

errors = st.floats(0.02, 1.0)


def heard_as(spread: float, speed: float, error: float) -> float:
    """Return the network's input for a speed, for a rig whose motor is not heard."""
    rig = replace(Rig.fit(KNOWN, SHORE_A), pitch=None, speeds=RigSpeeds(0.1, spread))
    one = KNOWN.take(np.zeros(1, np.intp))
    told = replace(one, speeds=np.full(1, speed), speed_errors=np.full(1, error))
    return float(pretrained().conditioned_on({Rig.ANY: rig}).inputs(told)[:, -HINTS:][0, 0]) / 4


@settings(max_examples=20)
@given(errors, errors, st.floats(0.4, 2.5))
def test_a_measurement_shrinks_by_the_ratio_of_the_variances(
    spread: float, error: float, ratio: float
) -> None:
    share = spread**2 / (spread**2 + error**2)
    assert heard_as(spread, 0.1 * ratio, error) == pytest.approx(share * np.log(ratio), abs=1e-6)


def test_an_exact_speed_is_believed_and_a_poor_one_is_not() -> None:
    assert heard_as(0.3, 0.2, np.nan) == pytest.approx(np.log(2), rel=0.01)
    assert heard_as(0.3, 0.2, 30.0) == pytest.approx(0.0, abs=0.001)
    assert heard_as(0.3, 0.2, np.inf) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("spread", "error", "heard_error"), [(0.3, 0.03, 0.1), (0.1, 0.06, 0.05)])
def test_spreads_are_those_of_the_rig(spread: float, error: float, heard_error: float) -> None:
    rng = np.random.default_rng(1)
    log, noise, heard = rng.standard_normal((3, 5000)) * [[spread], [error], [heard_error]]
    n = len(log)
    rig = RigSpeeds.fit(
        0.1 * np.exp(log + noise), np.full(n, error), log + heard, np.ones(n, np.bool_)
    )
    assert rig.usual == pytest.approx(0.1, rel=0.03)
    assert rig.spread == pytest.approx(spread, rel=0.05)
    assert rig.heard_error == pytest.approx(heard_error, rel=0.1)


@pytest.mark.parametrize(
    ("spread", "error", "is_used"),
    [
        (0.2, 0.1, True),
        (0.2, 0.35, True),
        (0.2, 0.5, False),
        (0.05, 0.01, True),
        (0.05, 0.2, False),
    ],
)
def test_measurements_that_add_little_to_the_usual_speed_are_not_used(
    spread: float, error: float, is_used: bool
) -> None:
    log, noise = np.random.default_rng(1).standard_normal((2, 500)) * [[spread], [error]]
    n = len(log)
    rig = RigSpeeds.fit(
        0.1 * np.exp(log + noise), np.full(n, error), np.zeros(n), np.zeros(n, np.bool_)
    )
    assert (rig is not None) == is_used


@pytest.mark.parametrize(("speed", "error"), [(1e-3, 5.0), (1e-4, 0.1), (0.1, 30.0), (10.0, 0.0)])
def test_one_bad_measurement_does_not_decide_for_the_rig(speed: float, error: float) -> None:
    log, noise, wrong = np.random.default_rng(1).standard_normal((3, 40)) * [[0.2], [0.03], [0.05]]
    speeds, errors = 0.1 * np.exp(log + noise), np.full(40, 0.03)
    speeds[7], errors[7] = speed, error
    rig = RigSpeeds.fit(speeds, errors, log + wrong, np.ones(40, np.bool_))
    assert rig.usual == pytest.approx(0.1, rel=0.1)
    assert rig.spread == pytest.approx(0.2, rel=0.3)
    assert rig.heard_error == pytest.approx(0.05, rel=0.4)


def with_speeds(touches: Touches, speed: float, error: float) -> Touches:
    n = len(touches)
    spread = np.exp(0.3 * np.random.default_rng(3).standard_normal(n))
    return replace(touches, speeds=speed * spread, speed_errors=np.full(n, error))


def test_each_contact_has_its_own_measurement() -> None:
    rig = Rig.fit(with_speeds(KNOWN, 0.1, 0.02), SHORE_A)
    model = pretrained().conditioned_on({Rig.ANY: rig})
    half = with_speeds(KNOWN, 0.1, 0.02)
    missing = np.arange(len(half)) % 2 == 0
    half = replace(half, speeds=np.where(missing, np.nan, half.speeds))
    features = model.inputs(half)[:, -HINTS:]
    np.testing.assert_array_equal(features[missing], model.inputs(KNOWN)[:, -HINTS:][missing])
    complete = model.inputs(with_speeds(KNOWN, 0.1, 0.02))[:, -HINTS:]
    np.testing.assert_array_equal(features[~missing], complete[~missing])


def test_the_speeds_of_a_rig_are_in_its_file() -> None:
    rig = Rig.fit(with_speeds(KNOWN, 0.1, 0.02), SHORE_A)
    model = pretrained().conditioned_on({Rig.ANY: rig})
    again = RigModel.from_arrays(model.to_arrays(), model.level)
    assert again.rigs[Rig.ANY].speeds == rig.speeds


@pytest.mark.parametrize("scalars", [(1e-200, 0), (0.2, 1e-200), (0.2, -1), (11, 0), (0.2, 11)])
def test_a_file_with_impossible_speeds_is_refused(scalars: tuple[float, float]) -> None:
    rig = Rig.fit(with_speeds(KNOWN, 0.1, 0.02), SHORE_A)
    model = pretrained().conditioned_on({Rig.ANY: rig})
    arrays = model.to_arrays()
    (name,) = (name for name in arrays if name.endswith(".speeds"))
    with pytest.raises(InputError, match=name):
        RigModel.from_arrays({**arrays, name: np.array(scalars, float)}, model.level)


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
    # Far from the usual speed the rotor may leave the spectrum, which starts at 100 Hz.
    own_values = np.exp(np.clip(spread * rng.standard_normal(30), np.log(0.8), np.log(1.25)))
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
