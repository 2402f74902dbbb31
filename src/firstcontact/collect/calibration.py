"""Calibration of fingertips: noise floors, taps, and force curves."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from firstcontact.core import (
    ArgumentError,
    Calibration,
    Channel,
    ChannelKind,
    FileError,
    Finger,
    ForceCurve,
    Layout,
    VibrationCalibration,
    finger_name,
)
from firstcontact.core.board import DIVIDER_OHM
from firstcontact.core.files import AnyPath
from firstcontact.core.layout import ADC_VOLTS, finger_words
from firstcontact.core.text import parse_float
from firstcontact.device import Source
from firstcontact.device.noise_floor import measure_noise, wait_for_arrivals
from firstcontact.device.source import LinkNews, require_source
from firstcontact.recording.table import read_rows

Say = Callable[[str], object]

#: Shortest and longest rest that is measured, s.
SECONDS = (0.1, 3600.0)
#: Least peak of a tap, as a multiple of the noise floor, and in V. Both are required.
FACTOR = 10.0
LEAST = 0.02
#: Duration over which the peak is searched, s.
LASTS = 0.1
#: Weakest tap with a finger or a pencil on a working buffer, V.
WEAK = 0.1
#: Largest ratio between the taps of two fingertips that are built alike.
ALIKE = 3.0
#: Fewest different weights for a curve of three parameters, and the heaviest weight, N.
FEWEST, HEAVIEST = 4, 1000.0


def calibrate(
    source: Source,
    *,
    seconds: float = 2.0,
    patience: float = 10.0,
    tap: bool = False,
    weights: AnyPath | Sequence[Weighing] | None = None,
    weigh: Sequence[float] = (),
    say: Say = lambda line: None,
    confirmed: Callable[[], bool] | None = None,
) -> Calibration:
    """Measure the noise of each fingertip at rest and, if requested, taps and force curves.

    Keep the hand open and still during the measurement. If the hand closes repeatedly, the noise is
    measured between its closings.

    Parameters
    ----------
    source
        Open source of the fingertips' samples.
    seconds, patience
        Duration of the measurement at rest, s, and longest additional wait until the hand rests, s.
    tap
        True to ask the person for a tap on each fingertip, and measure its peak.
    weights
        Voltages under known weights, to which force curves are fitted: a CSV file with the columns
        finger (index or thumb), newtons and volts, or the rows of such a file.
    weigh
        Known weights, N, to measure now: a person puts each on a taxel (force cell) of each finger,
        one after the other. Cannot be combined with ``weights``.
    say
        Function, such as ``print``, that is called with each line for the person at the device.
    confirmed
        Function that is called repeatedly while a person puts a weight of ``weigh`` in place. Once
        it returns True, the weight is measured.

    Returns
    -------
    Calibration
        Noise floors, and the taps and force curves that were measured.

    Raises
    ------
    InputError
        A parameter is not valid, the hand moves, a sensor gives no signal, or no tap was measured.

    Examples
    --------
    >>> import firstcontact as fc
    >>> with fc.open("twin", speed=8.0) as source:
    ...     calibration = fc.calibrate(source, seconds=0.5)
    >>> [sensor.finger.name for sensor in calibration.piezo]
    ['INDEX', 'THUMB']
    """
    require_source(source)
    shortest, longest = SECONDS
    if not shortest <= seconds <= longest:
        raise ArgumentError(
            f"the time at rest is {seconds:g} s: give {shortest:g} to {longest:g} s",
            parameter="seconds",
        )
    if not 0 <= patience <= longest:
        raise ArgumentError(
            f"the additional wait is {patience:g} s: give 0 to {longest:g} s", parameter="patience"
        )
    if weigh and weights is not None:
        raise ArgumentError(
            "known weights are either given (`weights`) or measured (`weigh`): leave one out",
            parameter="weigh",
        )
    if weigh and confirmed is None:
        raise ArgumentError(
            "a person must place each weight: also pass `confirmed`, a function that returns True "
            "once the weight is on the force sensor",
            parameter="weigh",
        )
    if isinstance(weights, str | os.PathLike):
        weights = read_weights(Path(weights))
    curves = () if weights is None else _curves(weights)
    layout = source.descriptor.layout
    say(f"measuring {seconds:g} s of rest: {rest_request(layout)}")
    calibration = measure_noise(source, seconds, patience)
    for sensor in calibration.piezo:
        words = rest_words(sensor, measured_channel(layout, sensor))
        say(f"{finger_name(sensor.finger):6} {words}")
    if tap:
        calibration = _measure_taps(source, calibration, say)
    if weigh and confirmed is not None:
        curves = _curves(_measure_weights(source, weigh, say, confirmed))
    calibration = replace(calibration, force=curves)
    for sentence in tap_warnings(calibration):
        say(f"warning: {sentence}")
    for curve in curves:
        say(
            f"{curve.finger.name.lower():6} force curve: leak {curve.leak:.3g} S, gain "
            f"{curve.gain:.3g} S, exponent {curve.exponent:.2f}, error {curve.rms:.2f} N RMS"
        )
    return calibration


def _measure_taps(source: Source, calibration: Calibration, say: Say) -> Calibration:
    """Ask the person to tap each fingertip. Return the calibration with the peaks of the taps."""
    layout = source.descriptor.layout
    for finger in layout.vibration_fingers:
        place = (
            finger_words(finger) if finger is None else f"fingertip of the {finger_words(finger)}"
        )
        say(f"tap the {place}")
        calibration = wait_for_tap(source, calibration, finger)
        sensor = next(p for p in calibration.piezo if p.finger is finger)
        words = tap_words(sensor.tap or 0.0, measured_channel(layout, sensor))
        say(f"{finger_name(finger):6} {words}")
    return calibration


def _curves(weighings: Sequence[Weighing]) -> tuple[ForceCurve, ...]:
    fingers = sorted({w.finger for w in weighings})
    if not fingers:
        raise ArgumentError("there are no weights: add a row for each weight", parameter="weights")
    return tuple(fit_force([w for w in weighings if w.finger is f]) for f in fingers)


def _measure_weights(
    source: Source, weigh: Sequence[float], say: Say, confirmed: Callable[[], bool]
) -> list[Weighing]:
    """Ask the person to put each weight of ``weigh``, N, on each finger.

    Return the forces with the voltages under them. Once ``confirmed`` returns True, a weight is
    measured.
    """
    weighings = []
    link = LinkNews(source.health)
    fingers = source.descriptor.layout.vibration_fingers
    for finger in (f for f in fingers if f is not None):
        name = finger_name(finger)
        for force in weigh:
            say(f"put {force:g} N on one taxel of the {finger_words(finger)} and press Enter")
            while not confirmed():
                source.read(0.1)
                for line in link.lines(source.health):
                    say(line)
            volts = loaded_volts(source, finger)
            say(f"{name:6} {force:g} N: {volts:.3f} V")
            weighings.append(Weighing(finger, force, volts))
    return weighings


def loaded_volts(source: Source, finger: Finger, seconds: float = 1.0) -> float:
    """Measure a finger's force cells. Return the mean voltage of the most loaded one, V."""
    layout = source.descriptor.layout
    columns = layout.columns(ChannelKind.FORCE, finger)
    if not columns:
        raise ArgumentError(
            f"the {finger_words(finger)} has no force channel, so its weights cannot be used: "
            "leave them out"
        )
    volts: list[np.ndarray] = []
    source.read(0)  # drop the samples from before the weight lay there
    while sum(map(len, volts)) < seconds * layout.rate:
        volts += [layout.physical(a.block.data, columns) for a in wait_for_arrivals(source)]
    return float(np.concatenate(volts).mean(axis=0).max())


def wait_for_tap(
    source: Source, calibration: Calibration, finger: Finger | None, patience: float = 20.0
) -> Calibration:
    """Wait for a tap on a fingertip. Return the calibration with the peak of the tap.

    Raises ArgumentError if no tap came within ``patience`` s.
    """
    layout = source.descriptor.layout
    columns = layout.columns(ChannelKind.VIBRATION, finger)
    offset = next((p.offset for p in calibration.piezo if p.finger is finger), 0.0)
    limit = max(LEAST, FACTOR * (calibration.noise(finger) or 0.0))
    tap = np.zeros(0)  # from the first sample above the limit on, V
    left = patience * layout.rate
    source.read(0)  # drop the samples from before the request
    while left > 0:
        for arrival in wait_for_arrivals(source):
            volts = np.abs(layout.physical(arrival.block.data, columns)[:, 0] - offset)
            left -= len(volts)
            above = np.flatnonzero(volts > limit)
            begin = 0 if len(tap) else above[0] if len(above) else len(volts)
            tap = np.append(tap, volts[begin:])
            if len(tap) >= LASTS * layout.rate:
                peak = float(tap[: round(LASTS * layout.rate)].max())
                piezo = (
                    replace(p, tap=peak) if p.finger is finger else p for p in calibration.piezo
                )
                return replace(calibration, piezo=tuple(piezo))
    raise ArgumentError(
        f"no tap on the {finger_words(finger)} was measured within {patience:g} s: tap harder, "
        "check the sensor's plug, or skip the tap test",
        parameter="tap",
    )


def tap_warnings(calibration: Calibration) -> Sequence[str]:
    """Return sentences about taps that are too weak or too different."""
    taps = {p.finger: p.tap for p in calibration.piezo if p.tap is not None}
    warnings = [
        f"the tap on the {finger_words(f)} gave only {tap:.3f} V: tap harder, or check the "
        "pad and the buffer"
        for f, tap in taps.items()
        # ``WEAK`` holds for a fingertip's pad and buffer, which a sensor of no finger lacks.
        if f is not None and tap < WEAK
    ]
    if len(taps) == 2 and max(taps.values()) > ALIKE * min(taps.values()):
        loud = max(taps, key=lambda f: taps[f])
        warnings.append(
            f"the tap on the {finger_words(loud)} was {taps[loud] / min(taps.values()):.1f} times "
            "as loud as the other: tap both alike, or check the pads"
        )
    return warnings


def measured_channel(layout: Layout, measured: VibrationCalibration) -> Channel | None:
    """Return the vibration channel that a measurement is from; None if it is not in the layout."""
    return next((c for c in layout.vibration if c.finger is measured.finger), None)


def is_tapped(layout: Layout) -> bool:
    """Return True if no vibration sensor is on a finger, so that a person taps the objects."""
    return all(finger is None for finger in layout.vibration_fingers)


def rest_request(layout: Layout) -> str:
    """Return the text that asks the person to keep the hand still for the measurement of noise."""
    return "touch nothing" if is_tapped(layout) else "keep the hand open and still, motor off"


def rest_words(measured: VibrationCalibration, channel: Channel | None) -> str:
    """Return a text with the noise and the offset of a sensor at rest, in the channel's unit."""
    noise, offset, unit = measured.noise, measured.offset, _unit(channel)
    if unit == "V":
        return f"noise {1e3 * noise:.2f} mV RMS, offset {1e3 * offset:+.2f} mV"
    return f"noise {noise:.3g} {unit} RMS, offset {offset:+.3g} {unit}"


def tap_words(tap: float, channel: Channel | None) -> str:
    """Return a text with the peak of a tap, in the channel's unit: "tap 0.412 V"."""
    return f"tap {tap:.3f} {_unit(channel)}"


def _unit(channel: Channel | None) -> str:
    unit = "V" if channel is None else channel.unit
    return "of full scale" if unit == "full scale" else unit


@dataclass(frozen=True, slots=True)
class Weighing:
    """Known force on one force cell of a finger, N, and the cell's output voltage, V."""

    finger: Finger
    newtons: float
    volts: float


def read_weights(path: Path) -> tuple[Weighing, ...]:
    """Read weighings from a CSV with the columns finger (index or thumb), newtons and volts."""
    weighings = []
    for line, row in read_rows(path, ("finger", "newtons", "volts")):
        try:
            finger = Finger[row["finger"].upper()]
            newtons, volts = parse_float(row["newtons"]), parse_float(row["volts"])
        except (KeyError, ValueError) as error:
            raise FileError(
                f"{path}, line {line}: give the finger (index or thumb), then newtons and volts "
                "as numbers"
            ) from error
        weighings.append(Weighing(finger, newtons, volts))
    return tuple(weighings)


def fit_force(weighings: Sequence[Weighing], resistor: float = DIVIDER_OHM) -> ForceCurve:
    """Fit the force curve of one finger's Velostat sheet to known forces and measured voltages.

    ``resistor`` is that of the voltage divider, ohm. Raises ArgumentError if the weights are too
    few, out of range, or do not give rising voltages.
    """
    finger = weighings[0].finger if weighings else Finger.INDEX
    subject = f"the weights of the {finger_words(finger)}"
    points = sorted(weighings, key=lambda w: w.newtons)
    force = np.array([w.newtons for w in points])
    volts = np.array([w.volts for w in points])
    if len({w.newtons for w in points}) < FEWEST:
        raise ArgumentError(
            f"{subject} have {len({w.newtons for w in points})} different values, but the "
            f"curve needs {FEWEST}: add weights"
        )
    if not (force >= 0).all() or not (force <= HEAVIEST).all():
        raise ArgumentError(
            f"{subject} lie between {force.min():g} and {force.max():g} N: give forces in "
            f"newtons from 0 to {HEAVIEST:g}"
        )
    if not ((volts > 0) & (volts < ADC_VOLTS)).all():
        raise ArgumentError(
            f"the voltages of {subject} are {volts.min():.3g} to {volts.max():.3g} V, but must lie "
            f"between 0 and {ADC_VOLTS:g} V: check the wiring"
        )
    levels = [(f, volts[force == f].mean()) for f in np.unique(force)]
    for (light, low), (heavy, high) in pairwise(levels):
        if high <= low:
            raise ArgumentError(
                f"{subject} must give a voltage that rises with the force, but {heavy:g} N gives "
                f"{high:.3f} V and {light:g} N gives {low:.3f} V: check the order of the weights"
            )
    curve = _fit_curve(finger, force, volts, resistor)
    rms = float(np.sqrt(np.mean((curve.newtons(volts) - force) ** 2)))
    return replace(curve, rms=rms)


def _fit_curve(
    finger: Finger, force: NDArray[np.float64], volts: NDArray[np.float64], resistor: float
) -> ForceCurve:
    """Fit the force curve of a finger to forces, N, and voltages, V, shape (n,)."""
    ratio = volts / ADC_VOLTS
    conductance = ratio / (1 - ratio) / resistor
    worth = (1 - ratio) ** 2  # dV/dg apart from a constant factor
    unit = float(conductance.max())
    strongest = float(force.max())

    def residuals(p: NDArray[np.float64]) -> NDArray[np.float64]:
        model = p[0] + np.exp(p[1]) * (force / strongest) ** p[2]
        return np.asarray((model - conductance / unit) * worth)

    low = float(conductance.min()) / unit
    start = [0.5 * low, math.log(max(1 - 0.5 * low, 1e-3)), 1.0]
    bounds = ([0.0, -10.0, 0.1], [1.0, 3.0, 4.0])
    best = least_squares(residuals, start, bounds=bounds, xtol=1e-12, ftol=1e-12, gtol=1e-12)
    leak, log_gain, exponent = (float(x) for x in best.x)
    gain = math.exp(log_gain) * unit / strongest**exponent
    return ForceCurve(finger, leak * unit, gain, exponent, 0.0, resistor)
