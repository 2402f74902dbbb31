from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from firstcontact.core.layout import (
    ADC_COUNTS,
    ADC_VOLTS,
    FINGERTIP_RATE,
    PIEZO_OFFSET_VOLTS,
    SUBCOUNTS,
    TAXELS,
)
from firstcontact.twin.sensor import (
    FORCE_READINGS,
    VelostatParameters,
    force_counts,
    piezo_counts,
)

TOP = (ADC_COUNTS - 1) * SUBCOUNTS
DT = 1 / FINGERTIP_RATE
EVEN = np.full(TAXELS, 1 / TAXELS)


def adc(volts: NDArray[np.float64]) -> NDArray[np.int64]:
    count = np.floor((volts + PIEZO_OFFSET_VOLTS) * ADC_COUNTS / ADC_VOLTS)
    return np.clip(count, 0, ADC_COUNTS - 1).astype(np.int64)


def forces(force: NDArray[np.float64], **changes: float) -> NDArray[np.int16]:
    p = VelostatParameters()._replace(**changes)
    return force_counts(force, EVEN, p, np.zeros(force.size), DT)


@pytest.mark.parametrize(("volts", "count"), [(9.0, TOP), (-9.0, 0), (0.0, 512 * SUBCOUNTS)])
def test_the_converter_clips_at_its_rails(volts: float, count: int) -> None:
    assert set(piezo_counts(np.full(50, volts))) == {count}


def test_integer_smoothing_is_the_float_one_within_one_subcount() -> None:
    rng = np.random.default_rng(2)
    volts = np.cumsum(rng.normal(0, 0.15, 4000))
    volts -= volts.mean()
    x = adc(volts) * SUBCOUNTS
    y = np.empty(x.size)
    y[0] = x[0]
    for i in range(1, x.size):
        y[i] = y[i - 1] + 0.5 * (x[i] - y[i - 1])
    error = piezo_counts(volts) - y
    assert np.abs(error).max() <= 1
    assert (error <= 0).all(), "rounding is down"


def test_taxels_are_read_in_turn_each_under_a_sliding_mean() -> None:
    # Without a threshold and with instant response the readings follow the force.
    p = VelostatParameters()._replace(
        threshold=0.0, rise=DT, fall=DT, creep_share=0.0, crosstalk=0.0
    )
    force = 20 * np.random.default_rng(3).random(600)
    out = force_counts(force, EVEN, p, np.zeros(600), DT)
    for taxel in range(TAXELS):
        g = p.leak + p.conductance * (force * EVEN[taxel]) ** p.exponent
        volts = ADC_VOLTS * p.resistor * g / (1 + p.resistor * g)
        readings = np.floor(volts * ADC_COUNTS / ADC_VOLTS)[taxel::TAXELS]
        for turn in range(FORCE_READINGS, readings.size):
            mean = readings[turn - FORCE_READINGS + 1 : turn + 1].mean()
            shown = out[taxel + turn * TAXELS : taxel + (turn + 1) * TAXELS, taxel]
            assert (shown == round(mean * SUBCOUNTS)).all()


def test_an_open_hand_reads_the_same_from_the_first_sample_on() -> None:
    out = forces(np.zeros(200))
    assert (out == out[0, 0]).all()
    assert 0 < out[0, 0] < TOP // 4


def test_less_than_the_threshold_is_not_felt() -> None:
    p = VelostatParameters()
    silent = forces(np.full(2000, 0.95 * p.threshold * TAXELS))
    felt = forces(np.full(2000, 2 * p.threshold * TAXELS))
    assert (silent == silent[0]).all()
    assert (felt[-1] > silent[-1]).all()


def test_the_sheet_is_slow_creeps_and_lets_go_later_than_it_took_hold() -> None:
    force = np.r_[np.zeros(500), np.full(3000, 12.0), np.zeros(3000)]
    one = forces(force).astype(float)[:, 0]
    one -= one[0]
    up = int(np.argmax(one[500:3500] > 0.5 * one[3499])) * DT
    down = int(np.argmax(one[3500:] < 0.5 * one[3499])) * DT
    assert 0.005 < up < down
    assert one[3499] > one[3000] > one[2500], "creep"


def test_a_row_neighbour_is_seen_through_the_divider() -> None:
    p = VelostatParameters()
    only_first = np.array([1.0, 0, 0, 0, 0, 0])
    out = force_counts(np.full(3000, 8.0), only_first, p, np.zeros(3000), DT)[-1]
    assert out[0] > out[1] > out[2]
    assert out[2] == out[3] == out[4] == out[5]


def test_the_force_converter_clips_too() -> None:
    p = VelostatParameters()
    out = force_counts(np.zeros(100), EVEN, p, np.full(100, 9.0), DT)
    assert out[-1].max() == TOP
    out = force_counts(np.zeros(100), EVEN, p, np.full(100, -9.0), DT)
    assert out[-1].min() == 0
