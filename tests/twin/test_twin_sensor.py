import numpy as np
import pytest
from numpy.typing import NDArray

from firstcontact.core.layout import ADC_COUNTS, ADC_VOLTS, FINGERTIP_RATE, SUBCOUNTS, TAXELS
from firstcontact.twin.mechanics import VelostatParameters
from firstcontact.twin.sensor import DeviceFilter, force_readings, open_reading, piezo_readings

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
    full_turns = counts.size - counts.size % TAXELS
    return counts[:full_turns].astype(np.int64).reshape(-1, TAXELS)


@pytest.mark.parametrize(("volts", "count"), [(9.0, TOP), (-9.0, 0), (0.0, 512)])
def test_the_converter_clips_at_its_rails(volts: float, count: int) -> None:
    assert set(piezo_readings(np.full(50, volts))) == {count}


def test_count_is_a_1024th_of_the_range() -> None:
    volt = ADC_VOLTS / ADC_COUNTS
    assert list(piezo_readings(volt * np.array([-1.0, -0.4, 0.4, 1.4]))) == [511, 511, 512, 513]


def test_taxels_are_read_in_turn() -> None:
    # Without a threshold and with instant response the readings follow the force.
    p = VelostatParameters()._replace(threshold=0.0, rise=DT, fall=DT, creep_share=0.0, row=0.0)
    force = 20 * np.random.default_rng(3).random(600)
    out = read(force, p)
    for taxel in range(TAXELS):
        g = p.leak + p.conductance * (force * EVEN[taxel]) ** p.exponent
        share = p.resistor * g / (1 + 3 * p.resistor * g)
        assert (out[:, taxel] == np.floor(share * ADC_COUNTS)[taxel::TAXELS]).all()


@pytest.mark.parametrize("cut", [1, 5, 6, 250, 399])
def test_readings_do_not_depend_on_the_pieces(cut: int) -> None:
    rng = np.random.default_rng(4)
    force, noise = 20 * rng.random(400), 0.004 * rng.standard_normal(400)
    p = VelostatParameters()
    expected = force_readings(force, EVEN, p, noise, DT, np.zeros((2, TAXELS)), 0)
    felt = np.zeros((2, TAXELS))
    begin = force_readings(force[:cut], EVEN, p, noise[:cut], DT, felt, 0)
    remainder = force_readings(force[cut:], EVEN, p, noise[cut:], DT, felt, cut)
    assert (np.r_[begin, remainder] == expected).all()


def test_open_hand_has_constant_readings() -> None:
    p = VelostatParameters()
    out = read(np.zeros(200), p)
    assert (out == open_reading(p)).all()
    assert 0 < open_reading(p) < TOP // 4


def test_force_below_the_threshold_changes_no_reading() -> None:
    p = VelostatParameters()
    silent = read(np.full(2000, 0.95 * p.threshold * TAXELS), p)
    felt = read(np.full(2000, 2 * p.threshold * TAXELS), p)
    assert (silent == silent[0]).all()
    assert (felt[-1] > silent[-1]).all()


def test_sheet_is_slow_creeps_and_has_a_longer_decay() -> None:
    force = np.r_[np.zeros(498), np.full(3000, 6.0), np.zeros(3000)]
    readings = read(force, VelostatParameters()).astype(float)[:, 0]
    readings -= readings[0]
    on, off = 498 // TAXELS, 3498 // TAXELS
    up = int(np.argmax(readings[on:off] > 0.5 * readings[off - 1])) * TAXELS * DT
    down = int(np.argmax(readings[off:] < 0.5 * readings[off - 1])) * TAXELS * DT
    assert 0.005 < up < down
    creeping = readings[[on + (off - on) * k // 4 for k in (1, 2, 3)]]
    assert (np.diff([*creeping, readings[off - 1]]) > 0).all(), "creep"


def test_taxel_alone_in_its_column_is_told_from_its_neighbours() -> None:
    # The filter of the device removes what the other taxels of the column and the row do.
    p = VelostatParameters()._replace(row=0.0, noise=0.0)
    shares = np.array([0.3, 0.0, 0.3, 0.3, 0.1, 0.0])
    scans = np.zeros((6000, 6), np.uint16)
    for f, force in enumerate((10.0, 0.0)):
        state = np.zeros((2, TAXELS))
        load = np.full(len(scans), force)
        scans[:, 2 + f] = force_readings(load, shares, p, 0 * load, DT, state, 0)
    pressed, unloaded = (DeviceFilter().update(scans)[-1, 2:14] / SUBCOUNTS).reshape(2, TAXELS)
    assert np.ptp(scans[-TAXELS:, 2]) > 100
    g = p.leak + p.conductance * np.maximum(10 * shares - p.threshold, 0.0) ** p.exponent
    alone = p.resistor * g / (1 + p.resistor * g) * ADC_COUNTS
    assert pressed == pytest.approx(alone, abs=6.0)
    assert pressed[[1, 5]] == pytest.approx(unloaded[[1, 5]], abs=3.0)
