"""Closing speed from encoders of several rates, with a known step or with reported speeds."""

import numpy as np
import pytest

from firstcontact.core import InputError
from firstcontact.signal import closing_speed

STEP = 1e-4


def measured(rate, speed, rng, *, resolution=STEP, change=0.0, factor=None):
    """Measure a finger whose speed changes by a share in the last 100 ms before the contact."""
    times = np.arange(-0.4, 0.0, 1 / rate) + rng.uniform(0, 1 / rate)
    late = np.minimum(times + 0.1, 0.1).clip(0)
    begin = speed / (1 + change)
    travel = begin * (times + change * late**2 / 0.2)
    positions = np.round((travel + rng.uniform(0, STEP)) / STEP) * STEP
    reported = None if factor is None else factor * begin * (1 + change * late / 0.1)
    return closing_speed(times, positions, 0.0, resolution=resolution, speeds=reported)


@pytest.mark.parametrize(("rate", "most"), [(30.0, 0.015), (100.0, 0.015), (500.0, 0.006)])
def test_an_encoder_of_known_step_gives_the_speed_and_an_honest_error(rate, most):
    rng = np.random.default_rng(1)
    made = [(s, measured(rate, s, rng)) for s in rng.uniform(0.04, 0.25, 800)]
    error = np.array([m.speed - s for s, m in made])
    stated = np.array([m.error for _, m in made])
    assert np.sqrt(np.mean((error / [s for s, _ in made]) ** 2)) < most
    assert np.mean(np.abs(error) <= 2 * stated) > 0.93


def test_a_wrong_step_is_seen_in_the_residuals():
    rng, errors = np.random.default_rng(2), []
    for _ in range(500):
        times = np.arange(-0.4, 0.0, 0.01) + rng.uniform(0, 0.01)
        positions = 0.1 * times + 1e-4 * rng.standard_normal(len(times))
        made = closing_speed(times, positions, 0.0, resolution=1e-6)
        errors.append(abs(made.speed - 0.1) <= 2 * made.error)
    assert np.mean(errors) > 0.9


@pytest.mark.parametrize("factor", [1.0, -57.0, 3e-3])
def test_reported_speeds_need_no_unit_and_follow_a_finger_that_slows_down(factor):
    rng = np.random.default_rng(3)
    line = [measured(500.0, 0.1, rng, change=-0.3) for _ in range(50)]
    both = [measured(500.0, 0.1, rng, change=-0.3, factor=factor) for _ in range(50)]
    away = [abs(np.mean([m.speed for m in made]) - 0.1) for made in (line, both)]
    assert away[1] < away[0]
    assert np.mean([abs(m.speed - 0.1) <= 2 * m.error for m in both]) > 0.9


def test_a_position_without_a_reported_speed_still_counts():
    times = np.arange(-0.1, 0.0, 0.005)
    made = closing_speed(times, 0.1 * times, 0.0, speeds=np.full(len(times), np.nan))
    assert made.speed == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("options", "parameter"), [({"speeds": [1.0]}, "speeds"), ({"resolution": -1.0}, "resolution")]
)
def test_impossible_options_are_refused(options, parameter):
    with pytest.raises(InputError) as caught:
        closing_speed([1, 2], [3, 4], 1.0, **options)
    assert caught.value.parameter == parameter
