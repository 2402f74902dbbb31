"""Simulation of the amplifier board in ngspice, and its comparison with the twin.

``write_page.py --measure`` runs it. It needs ngspice (Debian: ``apt-get install ngspice``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from circuit import COLUMNS, FINGERS, ROWS, parts
from disc import sensitivity
from numpy.typing import NDArray
from spice import COUNT, SAMPLE_TIME, board, sampled_charge, simulate, sound_input
from taxels import SHEET, Method, conductances, readings

from firstcontact.core.layout import ADC_VOLTS
from firstcontact.twin.mechanics import FingerParameters

#: A knock from 10 ms on: 40 V within 50 us, gone after another 500 us.
KNOCK = "PWL(0 0 10m 0 10.05m 40 10.55m 0 1 0)"
KNOCK_END = 10.55e-3
CELSIUS = (0.0, 27.0, 50.0)
#: Largest offset voltage of the amplifier, V (data sheet).
OFFSET = 0.5e-3
#: Deviation of the two leakage currents of a clamp from their mean (assumption).
UNEQUAL = 0.1
#: Limits of a pin of the Teensy, V (i.MX RT1062 data sheet), and of the amplifier's input, A.
PIN_VOLTS, INPUT_AMPERES = (-0.3, 3.6), 2e-3
#: Capacitance of a piezo disc of 20 to 27 mm, F: 10 to 25 nF in data sheets.
SOUND_DISC = 20e-9
#: Names of the results of :func:`response`.
RESPONSE = ("gain", "low_hz", "high_hz")
#: Largest relative difference between the board and the twin.
AGREEMENT = 0.07
#: Largest difference of two resistors of the table, as a share of the supply.
DIVIDER = 0.02
#: Largest deviation from half of the supply under 2 N, as a share of the supply.
HALF = 0.05
#: Largest current between two connected rows, A. The Teensy's maker recommends at most 4 mA.
SHORT_AMPERES = 5e-3
#: Wrong parts that :func:`check` must find, with the factor on their value.
WRONG = {
    "R1": 1.1, "R2": 0.8, "R10": 0.5, "R13": 2.0, "R15": 2.0, "R17": 0.9, "R18": 4.7 / 22,
    "R24": 2.0, "R28": 1.1, "R30": 2.0, "R31": 0.1, "R42": 0.9, "C10": 10.0, "C20": 0.5,
}  # fmt: skip
#: Conductance of the taxels in the test of the dividers, S.
TAXEL = 1 / 22e3


@dataclass(frozen=True)
class Board:
    """Measurements of the simulated board. Counts are steps of the 10-bit converter."""

    gain: float
    """Largest gain from the disc's open-circuit voltage to the converter."""
    low_hz: float
    """Frequency at which the gain is 3 dB lower, below its maximum, Hz."""
    high_hz: float
    """Frequency at which the gain is 3 dB lower, above its maximum, Hz."""
    noise_volts: float
    """RMS noise of the amplifier at the converter from 0.1 Hz to 1 MHz, V."""
    offset_counts: dict[str, float]
    """Offset by unequal leakage of the clamps, for each diode and temperature in Celsius."""
    amplifier_offset_counts: float
    """Offset by the largest offset voltage of the amplifier."""
    pin_volts: tuple[float, float]
    """Lowest and highest voltage at the converter during a knock of 40 V."""
    clamp_volts: tuple[float, float]
    """Lowest and highest voltage at the clamp during the knock."""
    input_amperes: float
    """Largest current into the amplifier's input during the knock, if it clamps at the rails."""
    recovery_s: float
    """Time from the end of the knock until the offset stays below one count, s."""
    coupling_counts: float
    """Largest deviation of the other finger during the knock."""
    ripple_counts: float
    """Peak to peak reading by 10 mV of 1 kHz on the supply, which is the converter's reference."""
    half_volts: float
    """Reference of both amplifiers, V."""
    thumb: tuple[float, float, float]
    """Gain of the thumb's amplifier and its corner frequencies."""
    force_volts: list[float]
    """Voltage of each column of both fingers behind equal taxels in a driven row, row by row."""
    short_amperes: tuple[float, float]
    """Smallest and largest current in two connected rows, one driven and one at ground, A."""
    carry_counts: tuple[float, float]
    """Steps that the piezo's reading leaves in the next reading of a column, and in the second."""
    tolerance: dict[str, tuple[float, float]]
    """1st and 99th percentile of gain and corners over random boards."""
    sound_hz: dict[str, float]
    """Frequency below which a sound input loses 3 dB of a two-euro disc, by its ohms."""


def response(finger: str = "index", **options: Any) -> tuple[float, float, float]:
    """Return (gain, low corner, high corner) of a finger's amplifier; corners in Hz.

    ``options`` go to :func:`spice.board`.
    """
    lines = board(discs={finger: "DC 0 AC 1"}, **options)
    return _corners(*simulate(lines, "ac dec 100 5 30k", f"vm(adc_{finger})"))


def resting(**options: Any) -> float:
    """Return by how much the index finger's converter input differs from 1.65 V at rest, counts."""
    _, volts = simulate(board(**options), "op", "v(adc_index)")
    return float(volts[0] - 1.65) / COUNT


def ripple() -> float:
    """Return the reading that 10 mV of 1 kHz on the supply cause, counts peak to peak.

    The converter compares with the supply, so its reading is a ratio.
    """
    lines = board(supply="DC 3.3 AC 10m")
    _, real, imaginary = simulate(lines, "ac lin 1 1k 1k", "vr(adc_index)", "vi(adc_index)")
    rest = resting() * COUNT + 1.65
    share = (real[0] + 1j * imaginary[0]) / 3.3 - rest * 10e-3 / 3.3**2
    return float(2 * abs(share) * 3.3 / COUNT)


def columns(**options: Any) -> list[float]:
    """Return the voltage of each column while a row of equally pressed taxels is driven, V.

    The list has all columns of both fingers for row 0, then for row 1 and row 2.
    """
    nets = [f"v({finger}_column_{c})" for finger in FINGERS for c in range(COLUMNS)]
    volts = [
        simulate(board(driven=row, taxel=TAXEL, **options), "op", *nets)[1:] for row in range(ROWS)
    ]
    return [float(value[0]) for row in volts for value in row]


def short_current(**options: Any) -> tuple[float, float]:
    """Return (least, largest) current in a pin if two rows of a finger are connected, A."""
    amperes = [
        simulate(
            [*board(driven=row, **options), f"Rshort {finger}_line_{row} {finger}_line_{other} 1m"],
            "op", f"i(vrow_{finger}_{row})",
        )[1]
        for finger in FINGERS
        for row in range(ROWS)
        for other in range(ROWS) if other != row
    ]  # fmt: skip
    return float(np.abs(amperes).min()), float(np.abs(amperes).max())


def carries() -> tuple[float, float]:
    """Return how much the piezo's level changes the next and second next reading, counts.

    Both readings are those of one column, after the piezo was read.
    """
    ohm = next(p.value for p in parts() if p.purpose.startswith("divider of column"))
    _, volts = simulate(sampled_charge(1.65, ohm), f"tran 10n {SAMPLE_TIME} uic", "v(sample)")
    left = float(volts[-1]) / 1.65
    return left * 1.65 / COUNT, left**2 * 1.65 / COUNT


def changed(results: Board, values: Mapping[str, float]) -> Board:
    """Return the measurements of a board on which some parts have other values, by reference."""
    gain, low, high = response(values=values)
    return replace(
        results,
        gain=gain,
        low_hz=low,
        high_hz=high,
        thumb=response("thumb", values=values),
        half_volts=float(simulate(board(values=values), "op", "v(vref)")[1][0]),
        force_volts=columns(values=values),
        short_amperes=short_current(values=values),
    )


def is_found(results: Board, reference: str, factor: float) -> bool:
    """Return True if :func:`check` fails once the value of a part is multiplied by ``factor``."""
    value = next(part.value for part in parts() if part.reference == reference)
    try:
        check(changed(results, {reference: factor * value}))
    except AssertionError:
        return True
    return False


def noise() -> float:
    """Return the RMS noise of the amplifier at the converter, V."""
    lines = board(discs={"index": "DC 0 AC 1"})
    # Versions of ngspice print the total differently, so the spectrum is integrated here.
    analysis = "noise v(adc_index) Vdisc_index dec 100 0.1 1meg\nsetplot noise1"
    rates, density = simulate(lines, analysis, "onoise_spectrum")
    return float(np.sqrt(np.trapezoid(density**2, rates)))


def tolerances(boards: int, seed: int) -> dict[str, tuple[float, float]]:
    """Return the 1st and 99th percentile of gain and corner frequencies, by name.

    The values of the parts are random within their tolerances, on ``boards`` boards.
    """
    rng = np.random.default_rng(seed)
    valued = [part for part in parts() if part.value]
    scores = []
    for _ in range(boards):
        deviations = rng.uniform(-1, 1, len(valued))
        scores.append(
            response(
                values={
                    part.reference: part.value * (1 + part.tolerance * deviation)
                    for part, deviation in zip(valued, deviations, strict=True)
                }
            )
        )
    ranks = np.percentile(scores, [1, 99], axis=0).T
    return {
        name: (float(low), float(high)) for name, (low, high) in zip(RESPONSE, ranks, strict=True)
    }


def sound_corner(input_ohm: float, disc: float) -> float:
    """Return the frequency below which a sound input loses 3 dB of the disc's signal, Hz."""
    rates, gains = simulate(sound_input(input_ohm, disc), "ac dec 100 1 20k", "vm(input)")
    return float(np.interp(gains[-1] / np.sqrt(2), gains, rates))


def measure(boards: int, seed: int) -> Board:
    """Simulate the board, and return all measurements.

    ``boards`` is the number of boards with random values.
    """
    vectors = [f"v({net})" for net in ("adc_index", "clamp_index", "adc_thumb")]
    lines = board(discs={"index": KNOCK})
    times, adc, clamp, other = simulate(lines, "tran 20u 200m 0 5u", *vectors)
    series = next(p.value for p in parts() if set(p.pins.values()) == {"clamp_index", "in_index"})
    gain, low, high = response()
    return Board(
        gain=gain,
        low_hz=low,
        high_hz=high,
        noise_volts=noise(),
        offset_counts={
            f"{diode}_{celsius:g}": abs(
                resting(diode=diode, celsius=celsius, leakage=(1 + UNEQUAL, 1 - UNEQUAL))
            )
            for diode in ("bav199", "bat54s")
            for celsius in CELSIUS
        },
        amplifier_offset_counts=abs(resting(offsets={"out_index": OFFSET})),
        pin_volts=(float(adc.min()), float(adc.max())),
        clamp_volts=(float(clamp.min()), float(clamp.max())),
        input_amperes=float(np.maximum(clamp - 3.3, -clamp).max()) / series,
        recovery_s=float(times[np.abs(adc - adc[0]) > COUNT].max()) - KNOCK_END,
        coupling_counts=float(np.abs(other - other[0]).max()) / COUNT,
        ripple_counts=ripple(),
        half_volts=float(simulate(board(), "op", "v(vref)")[1][0]),
        thumb=response("thumb"),
        force_volts=columns(),
        short_amperes=short_current(),
        carry_counts=carries(),
        tolerance=tolerances(boards, seed),
        sound_hz={f"{ohm / 1e3:g}k": sound_corner(ohm, SOUND_DISC) for ohm in (2e3, 10e3, 1e6)},
    )


def twin_response() -> tuple[float, float, float]:
    """Return (gain, low corner, high corner) of the twin's amplifier; corners in Hz.

    The twin has a high pass and a low pass of first order in series.
    """
    finger = FingerParameters()
    rates = np.geomspace(5, 30e3, 3000)
    high_pass = 2j * np.pi * rates * finger.piezo_time_constant
    gains = np.abs(
        finger.gain * high_pass / (1 + high_pass) / (1 + 1j * rates / finger.buffer_cutoff)
    )
    return _corners(rates, gains)


def check(results: Board) -> None:
    """Raise AssertionError if board and twin differ, or if a pin leaves its voltage limits."""
    for finger in ((results.gain, results.low_hz, results.high_hz), results.thumb):
        for name, ours, twin in zip(
            ("gain", "lower corner", "upper corner"), finger, twin_response(), strict=True
        ):
            assert abs(ours / twin - 1) <= AGREEMENT, (
                f"{name}: {ours:.4g} on the board, {twin:.4g} in the twin"
            )
    expected = readings(np.array([TAXEL] * COLUMNS + [0.0] * (ROWS - 1) * COLUMNS), Method.GROUNDED)
    for place, volts in enumerate(results.force_volts):
        assert abs(volts - expected[0]) <= DIVIDER * expected[0], (
            f"column {place % COLUMNS}: {volts:.3f} V on the board, {expected[0]:.3f} V in the twin"
        )
    assert abs(results.half_volts / 1.65 - 1) <= DIVIDER, f"{results.half_volts:.3f} V"
    expected_amperes = ADC_VOLTS / (2 * SHEET.row)
    assert expected_amperes <= SHORT_AMPERES, f"{expected_amperes} A in connected rows"
    for amperes in results.short_amperes:
        assert abs(amperes / expected_amperes - 1) <= DIVIDER, (
            f"connected rows: {amperes:.3g} A on the board, {expected_amperes:.3g} A in the twin"
        )
    # Two newtons on a taxel give half of the supply.
    half = readings(np.append(conductances([2.0]), np.zeros(ROWS * COLUMNS - 1)), Method.SOLVED)[0]
    assert abs(half / ADC_VOLTS - 0.5) <= HALF, f"{half:.2f} V at 2 N"
    assert results.carry_counts[1] < 1 / 2, results.carry_counts
    volts = sensitivity().all
    assert abs(volts / FingerParameters().piezo_volts_per_newton - 1) <= AGREEMENT, (
        f"{volts:.4g} V/N of the disc"
    )
    assert PIN_VOLTS[0] <= results.pin_volts[0] <= results.pin_volts[1] <= PIN_VOLTS[1], (
        results.pin_volts
    )
    assert results.input_amperes <= INPUT_AMPERES, results.input_amperes
    assert max(v for k, v in results.offset_counts.items() if k.startswith("bav199")) < 1


def _corners(rates: NDArray[np.float64], gains: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return the largest gain, and the two frequencies at which it is 3 dB lower, Hz."""
    peak, half = int(gains.argmax()), float(gains.max()) / np.sqrt(2)
    low = np.interp(half, gains[: peak + 1], rates[: peak + 1])
    high = np.interp(-half, -gains[peak:], rates[peak:])
    return float(gains[peak]), float(low), float(high)
