"""Closing speed from positions, and from encoders with a known step or with speeds."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import ArrayLike
from scipy.stats import norm, t

from firstcontact.core import InputError
from firstcontact.signal import closing_speed
from firstcontact.signal._closing_speed import _small_sample_factor

TIMES = np.arange(-0.2, 0.1, 0.005)


@given(
    st.floats(0.01, 0.3), st.sampled_from([-1.0, 1.0]), st.floats(-1e3, 1e3), st.floats(-0.5, 0.5)
)
def test_positions_on_a_line_give_its_slope(
    speed: float, direction: float, at: float, zero: float
) -> None:
    measured = closing_speed(TIMES + at, zero + direction * speed * TIMES, at)
    assert measured.speed == pytest.approx(speed, rel=1e-6)


def test_what_comes_after_the_contact_or_long_before_it_does_not_count() -> None:
    positions = np.where(TIMES < -0.06, 5.0, 0.1 * TIMES)
    positions[TIMES > -0.002] = np.nan
    measured = closing_speed(TIMES, positions, 0.0)
    assert measured.speed == pytest.approx(0.1)


@pytest.mark.parametrize("times", [[], [-0.02, -0.01], [-0.02] * 5, [0.01, 0.02, 0.03]])
def test_too_few_positions_give_no_speed(times: list[float]) -> None:
    assert closing_speed(times, np.linspace(0, 0.01, len(times)), 0.0) is None


@pytest.mark.parametrize(("times", "positions"), [([1, 2], [3]), ([1], 3), ([[1], [2]], [3, 4])])
def test_another_number_of_positions_than_times_is_refused(
    times: ArrayLike, positions: ArrayLike
) -> None:
    with pytest.raises(InputError, match="times") as caught:
        closing_speed(times, positions, 1.0)
    assert caught.value.parameter == "positions"


def test_a_finger_at_rest_gives_no_speed() -> None:
    assert closing_speed(TIMES, np.full(len(TIMES), 0.02), 0.0) is None


def test_the_error_of_many_positions_is_that_of_repeated_measurements() -> None:
    rng = np.random.default_rng(1)
    times = np.arange(-0.1, 0.0, 1e-3)
    made = [
        closing_speed(times, 0.13 * times + 1e-4 * rng.standard_normal(len(times)), 0.0)
        for _ in range(2000)
    ]
    speeds, errors = np.array([(m.speed, m.error) for m in made if m is not None]).T
    assert len(speeds) == 2000
    assert speeds.mean() == pytest.approx(0.13, rel=0.01)
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(speeds.std(), rel=0.08)


@pytest.mark.parametrize("rate", [65.0, 100.0, 200.0])
def test_two_errors_are_exceeded_as_rarely_with_few_positions(rate: float) -> None:
    rng = np.random.default_rng(1)
    deviations = []
    for _ in range(2000):
        times = np.arange(-0.1, 0.0, 1 / rate) + rng.uniform(0, 1 / rate)
        made = closing_speed(times, 0.13 * times + 1e-4 * rng.standard_normal(len(times)), 0.0)
        deviations.append((made.speed - 0.13) / made.error)
    assert 0.02 < np.mean(np.abs(deviations) > 2) < 0.08


@pytest.mark.parametrize("steps", [[0, 1, 2, 3, 4], [0, 1, 2, 4, 5], [0, 1, 1, 2, 2], [4, 3, 2]])
def test_an_exact_staircase_has_an_error(steps: list[int]) -> None:
    times = -0.045 + 0.01 * np.arange(len(steps))
    made = closing_speed(times, 0.2 + 1e-3 * np.array(steps), 0.0)
    least = 1e-3 / np.sqrt(12 * ((times - times.mean()) ** 2).sum())
    assert made.error >= 0.999 * least


def test_the_travel_between_positions_without_steps_is_no_error() -> None:
    times = np.arange(-0.05, 0.0, 0.01)
    positions = 0.13 * times + 1e-5 * np.random.default_rng(1).standard_normal(len(times))
    made = closing_speed(times, positions, 0.0)
    assert made.error < 0.01 * made.speed


def test_coarse_steps_of_an_encoder_count_as_error() -> None:
    step = 2e-3
    coarse = closing_speed(TIMES, np.floor(0.1 * TIMES / step) * step, 0.0)
    used = TIMES[(TIMES >= -0.0501) & (TIMES <= -0.003)]
    least = step / np.sqrt(12) / np.sqrt(((used - used.mean()) ** 2).sum())
    assert coarse.error >= 0.99 * least
    assert abs(coarse.speed - 0.1) < 4 * coarse.error


def test_few_positions_enlarge_the_error_by_the_quantile_of_student() -> None:
    probability = float(norm.cdf(2))
    for freedom in range(1, 200):
        assert _small_sample_factor(freedom) == pytest.approx(
            t.ppf(probability, freedom) / 2, rel=2e-3
        )


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
