from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from firstcontact.core import ADC_COUNTS, ADC_VOLTS, FINGERTIP_RATE, TAXELS
from firstcontact.twin import VelostatParameters
from firstcontact.twin._sensor import force_readings, open_reading, piezo_readings

TOP = ADC_COUNTS - 1
DT = 1 / FINGERTIP_RATE
EVEN = np.full(TAXELS, 1 / TAXELS)


def read(
    force: NDArray[np.float64],
    p: VelostatParameters,
    shares: NDArray[np.float64] = EVEN,
    noise: float = 0.0,
) -> NDArray[np.int64]:
    """Return the readings of each taxel, shape (turns, 6)."""
    felt = np.zeros((2, TAXELS))
    counts = force_readings(force, shares, p, np.full(force.size, noise), DT, felt, 0)
    whole = counts.size - counts.size % TAXELS
    return counts[:whole].astype(np.int64).reshape(-1, TAXELS)


@pytest.mark.parametrize(("volts", "count"), [(9.0, TOP), (-9.0, 0), (0.0, 512)])
def test_the_converter_clips_at_its_rails(volts: float, count: int) -> None:
    assert set(piezo_readings(np.full(50, volts))) == {count}


def test_a_count_is_a_1024th_of_the_range() -> None:
    volt = ADC_VOLTS / ADC_COUNTS
    assert list(piezo_readings(volt * np.array([-1.0, -0.4, 0.4, 1.4]))) == [511, 511, 512, 513]


def test_taxels_are_read_in_turn() -> None:
    # Without a threshold and with instant response the readings follow the force.
    p = VelostatParameters()._replace(
        threshold=0.0, rise=DT, fall=DT, creep_share=0.0, crosstalk=0.0
    )
    force = 20 * np.random.default_rng(3).random(600)
    out = read(force, p)
    for taxel in range(TAXELS):
        g = p.leak + p.conductance * (force * EVEN[taxel]) ** p.exponent
        volts = ADC_VOLTS * p.resistor * g / (1 + p.resistor * g)
        assert (out[:, taxel] == np.floor(volts * ADC_COUNTS / ADC_VOLTS)[taxel::TAXELS]).all()


@pytest.mark.parametrize("cut", [1, 5, 6, 250, 399])
def test_readings_in_two_pieces_are_those_in_one(cut: int) -> None:
    rng = np.random.default_rng(4)
    force, noise = 20 * rng.random(400), 0.004 * rng.standard_normal(400)
    p = VelostatParameters()
    whole = force_readings(force, EVEN, p, noise, DT, np.zeros((2, TAXELS)), 0)
    felt = np.zeros((2, TAXELS))
    begin = force_readings(force[:cut], EVEN, p, noise[:cut], DT, felt, 0)
    rest = force_readings(force[cut:], EVEN, p, noise[cut:], DT, felt, cut)
    assert (np.r_[begin, rest] == whole).all()


def test_an_open_hand_reads_the_same_from_the_first_sample_on() -> None:
    p = VelostatParameters()
    out = read(np.zeros(200), p)
    assert (out == open_reading(p)).all()
    assert 0 < open_reading(p) < TOP // 4


def test_less_than_the_threshold_is_not_felt() -> None:
    p = VelostatParameters()
    silent = read(np.full(2000, 0.95 * p.threshold * TAXELS), p)
    felt = read(np.full(2000, 2 * p.threshold * TAXELS), p)
    assert (silent == silent[0]).all()
    assert (felt[-1] > silent[-1]).all()


def test_the_sheet_is_slow_creeps_and_lets_go_later_than_it_took_hold() -> None:
    force = np.r_[np.zeros(498), np.full(3000, 12.0), np.zeros(3000)]
    one = read(force, VelostatParameters()).astype(float)[:, 0]
    one -= one[0]
    on, off = 498 // TAXELS, 3498 // TAXELS
    up = int(np.argmax(one[on:off] > 0.5 * one[off - 1])) * TAXELS * DT
    down = int(np.argmax(one[off:] < 0.5 * one[off - 1])) * TAXELS * DT
    assert 0.005 < up < down
    creeping = one[[on + (off - on) * k // 4 for k in (1, 2, 3)]]
    assert (np.diff([*creeping, one[off - 1]]) > 0).all(), "creep"


def test_a_row_neighbour_is_seen_through_the_divider() -> None:
    only_first = np.array([1.0, 0, 0, 0, 0, 0])
    out = read(np.full(3000, 8.0), VelostatParameters(), only_first)[-1]
    assert out[0] > out[1] > out[2]
    assert out[2] == out[3] == out[4] == out[5]


@pytest.mark.parametrize(("noise", "count"), [(9.0, TOP), (-9.0, 0)])
def test_the_force_converter_clips_too(noise: float, count: int) -> None:
    assert (read(np.zeros(100), VelostatParameters(), noise=noise) == count).all()
