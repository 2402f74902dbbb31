"""Calibration of fingertips: noise floors, taps, and force curves."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from firstcontact.collect._force_fit import Weighing, fit_force, read_weights
from firstcontact.collect._sensor_words import measured_channel, rest_request, rest_words, tap_words
from firstcontact.collect._tap import tap_warnings, wait_for_tap
from firstcontact.core import (
    AnyPath,
    Calibration,
    ChannelKind,
    Finger,
    ForceCurve,
    InputError,
    finger_name,
)
from firstcontact.device import LinkNews, Source, measure_noise, require_source, wait_for_arrivals

Say = Callable[[str], object]

#: Shortest and longest rest that is measured, s.
SECONDS = (0.1, 3600.0)


def silent(line: str) -> None:
    """Ignore a line. It is the default for ``say``."""


def calibrate(
    source: Source,
    *,
    seconds: float = 2.0,
    patience: float = 10.0,
    tap: bool = False,
    weights: AnyPath | Sequence[Weighing] | None = None,
    weigh: Sequence[float] = (),
    say: Say = silent,
    confirmed: Callable[[], bool] | None = None,
) -> Calibration:
    """Measure the noise floors of an open source and, on request, taps and force curves.

    Keep the hand open and still during the measurement. If the hand closes repeatedly, the noise is
    measured between its closings.

    Parameters
    ----------
    source
        An open source.
    seconds
        Duration of the measurement at rest, s.
    patience
        Longest additional time to wait for rest, s.
    tap
        True to measure a tap on each fingertip.
    weights
        Measurements with known weights, to which force curves are fitted: a CSV file with the
        columns finger, newtons and volts, or the rows of such a file.
    weigh
        Known weights, N. A person puts each weight on a taxel of each finger, one after the other.
        Cannot be combined with ``weights``.
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
        A parameter cannot be used, the hand does not rest, a sensor is dead, or a tap is missing.

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
        raise InputError(
            f"the time at rest must lie between {shortest:g} and {longest:g} s",
            parameter="seconds",
        )
    if not 0 <= patience <= longest:
        raise InputError(
            f"the additional wait must lie between 0 and {longest:g} s", parameter="patience"
        )
    if weigh and weights is not None:
        raise InputError(
            "voltages of known weights are given (`weights`), and others would be measured: leave "
            "one of them out",
            parameter="weigh",
        )
    if weigh and confirmed is None:
        raise InputError(
            "weighing needs a person: also pass `confirmed`, a function that returns True once "
            "the weight is on the taxel",
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
        calibration = _with_taps(source, calibration, say)
    if weigh and confirmed is not None:
        curves = _curves(_weighings(source, weigh, say, confirmed))
    calibration = replace(calibration, force=curves)
    for sentence in tap_warnings(calibration):
        say(f"warning: {sentence}")
    for curve in curves:
        say(
            f"{curve.finger.name.lower():6} force curve: leak {curve.leak:.3g} S, gain "
            f"{curve.gain:.3g} S, exponent {curve.exponent:.2f}, error {curve.rms:.2f} N RMS"
        )
    return calibration


def _with_taps(source: Source, calibration: Calibration, say: Say) -> Calibration:
    """Ask for a tap on each fingertip. Return the calibration with these taps."""
    layout = source.descriptor.layout
    for finger in layout.vibration_fingers:
        place = "sensor" if finger is None else f"{finger_name(finger)}'s fingertip"
        say(f"tap the {place}")
        calibration = wait_for_tap(source, calibration, finger)
        sensor = next(p for p in calibration.piezo if p.finger is finger)
        if sensor.tap is not None:
            words = tap_words(sensor.tap, measured_channel(layout, sensor))
            say(f"{finger_name(finger):6} {words}")
    return calibration


def _curves(weighings: Sequence[Weighing]) -> tuple[ForceCurve, ...]:
    """Return a force curve for each finger, fitted to its weighings."""
    fingers = sorted({w.finger for w in weighings})
    if not fingers:
        raise InputError("no weights are given: add a line for each weight", parameter="weights")
    return tuple(fit_force([w for w in weighings if w.finger is f]) for f in fingers)


def _weighings(
    source: Source, weigh: Sequence[float], say: Say, confirmed: Callable[[], bool]
) -> list[Weighing]:
    """Ask for each weight on each finger. Return the measured voltages."""
    weighings = []
    link = LinkNews(source.health)
    fingers = source.descriptor.layout.vibration_fingers
    for finger in (f for f in fingers if f is not None):
        name = finger_name(finger)
        for force in weigh:
            say(f"put {force:g} N on one taxel of the {name} and press Enter")
            while not confirmed():
                source.read(0.1)
                for line in link.lines(source.health):
                    say(line)
            volts = loaded_volts(source, finger)
            say(f"{name:6} {force:g} N: {volts:.3f} V")
            weighings.append(Weighing(finger, force, volts))
    return weighings


def loaded_volts(source: Source, finger: Finger, seconds: float = 1.0) -> float:
    """Return the mean voltage of a finger's most loaded taxel, V.

    Parameters
    ----------
    source
        An open source.
    finger
        Finger whose force channels are read.
    seconds
        Time over which the voltage is averaged, s by the device's clock.

    Raises
    ------
    InputError
        The finger has no force channel, or no samples come.
    """
    layout = source.descriptor.layout
    columns = layout.columns(ChannelKind.FORCE, finger)
    if not columns:
        raise InputError(
            f"the {finger.name.lower()} has no force channel, so its weights cannot be used: "
            "leave them out"
        )
    total = np.zeros(len(columns))
    count = 0
    source.read(0)  # drop the samples from before the weight lay there
    while count < seconds * layout.rate:
        for arrival in wait_for_arrivals(source):
            volts = layout.physical(arrival.block.data, columns)
            total += volts.sum(axis=0)
            count += len(volts)
    return float((total / count).max())
