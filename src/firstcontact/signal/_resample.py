"""To another sampling rate, explicitly and on record."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ChannelKind, Contact, Dataset, InputError, Pinch

#: Half of the anti-aliasing filter, in samples of the lower of the two rates.
HALF_LENGTH = 10
#: Of its Kaiser window.
BETA = 5.0
#: Points of the spectrum, by tap, from which the phase is made.
FINE = 16
#: Largest denominator of the ratio of the rates. Usual rates are met within 2 ppm and any up to
#: 1 MHz within 250 ppm, 0.08 ms in a pinch of 0.3 s; a larger one makes the filter too long to run.
LARGEST_RATIO = 2000
#: Largest error of the ratio, as a share.
FARTHEST_OFF = 0.001
#: Most samples that are made of one: what is between them nobody measured, and memory is bounded.
MOST_OF_ONE = 10


#: Longest that the filter looks ahead, s.
LONGEST_AHEAD = 0.0005


def lookahead(old: float, new: float) -> float:
    """Time that :func:`resample` looks ahead, s; 0 where the rates are the same."""
    if old == new:
        return 0.0
    ratio = _ratio(old, new)
    return _low_pass(ratio, old)[1] / (ratio.numerator * old)


def check_rates(old: float, new: float) -> None:
    """Refuse rates between which samples cannot be resampled.

    Parameters
    ----------
    old, new
        Rates, Hz.

    Raises
    ------
    InputError
        The new rate is more than ten times as high, or too low for the filter.
    """
    if new > MOST_OF_ONE * old:
        raise InputError(
            f"samples at {old:g} Hz cannot stand for ones at {new:g} Hz, more than "
            f"{MOST_OF_ONE} times as many: train a model at their rate"
        )
    if abs(_ratio(old, new) * old / new - 1) > FARTHEST_OFF:
        raise InputError(
            f"samples at {old:g} Hz are too many for a filter to {new:g} Hz: set the device to a "
            "lower rate, or train a model at its rate"
        )


def _ratio(old: float, new: float) -> Fraction:
    return Fraction(new / old).limit_denominator(LARGEST_RATIO)


@lru_cache(maxsize=16)
def _low_pass(ratio: Fraction, old: float) -> tuple[NDArray[np.float64], int]:
    """The anti-aliasing filter between the samples of both rates, and how many it looks ahead.

    Its amplitude is that of the Kaiser-windowed filter which SciPy resamples with, its
    phase the least there is: what rings, rings after an onset. How far it lags at low
    frequencies is taken off the times of its samples: only so far does it look ahead.
    """
    from scipy.signal import firwin, minimum_phase

    if ratio == 1:  # as of 4936 Hz and a clock that is a little off
        return np.ones(1), 0
    slower = max(ratio.numerator, ratio.denominator)
    symmetric = firwin(2 * HALF_LENGTH * slower + 1, 1 / slower, window=("kaiser", BETA))
    points = 2 ** int(np.ceil(np.log2(FINE * len(symmetric))))
    taps = minimum_phase(symmetric, n_fft=points, half=False)
    taps /= taps.sum()
    lag = round(float(np.arange(len(taps)) @ taps))
    return taps, min(lag, int(LONGEST_AHEAD * ratio.numerator * old))


def _position(position: int, ratio: Fraction) -> int:
    return round(position * ratio)


def resample(x: NDArray[Any], old: float, new: float) -> NDArray[np.float64]:
    """Polyphase resampling with a minimum-phase low-pass.

    It passes half of the amplitude at half the lower rate, 0.08 of it at 0.55 and 0.003 (-50 dB)
    from 0.6 of that rate on. Nothing comes earlier than :func:`lookahead` before its cause, which
    is 1.8 samples of the lower rate and 0.5 ms at most; where the filter lags by more (below
    3.6 kHz) the rest delays what comes out.

    Parameters
    ----------
    x
        Shape (samples, channels).
    old, new
        Rates, Hz.

    Returns
    -------
    ndarray
        Shape (about samples x new / old, channels).
    """
    from scipy.signal import resample_poly

    ratio = _ratio(old, new)
    taps, ahead = _low_pass(ratio, old)
    # SciPy takes the middle of a filter as its present: zeros put it there.
    padded = np.concatenate([np.zeros(max(0, len(taps) - 1 - 2 * ahead)), taps])
    out: NDArray[np.float64] = resample_poly(
        np.asarray(x, dtype=np.float64),
        ratio.numerator,
        ratio.denominator,
        axis=0,
        window=padded,
        padtype="edge",
    )
    return out


def _resample_pinch(pinch: Pinch, new: float) -> Pinch:
    layout = pinch.layout
    ratio = _ratio(layout.rate, new)
    data = resample(pinch.data, layout.rate, new).astype(np.float32)
    strips = list(layout.columns(ChannelKind.STRIP))
    if strips:
        # A switch is open or closed: nothing in between.
        nearest = np.rint(np.arange(len(data)) / float(ratio)).astype(np.intp)
        data[:, strips] = pinch.data[np.minimum(nearest, len(pinch.data) - 1)][:, strips]
    first = _position(pinch.first_sample, ratio)

    def at(sample: int) -> int:
        return first + _position(sample - pinch.first_sample, ratio)

    return Pinch(
        data,
        replace(layout, rate=new),
        pinch.label,
        first,
        tuple(Contact(c.finger, at(c.sample), at(c.decided)) for c in pinch.truth),
        None if pinch.motor_start is None else at(pinch.motor_start),
        pinch.calibration,
        pinch.groups,
    )


def resample_dataset(dataset: Dataset, rate: float) -> Dataset:
    """All pinches at another rate, truth moved along, and a note that says so.

    Data already at the rate come back as they are. Samples become float32 in
    the raw unit of the layout, so that its scale and offset still hold; strips
    take the nearest sample.

    Parameters
    ----------
    dataset
        The pinches.
    rate
        New rate, Hz.

    Returns
    -------
    Dataset
        With one more sentence in ``notes``.

    Raises
    ------
    InputError
        As of :func:`check_rates`.
    """
    if not len(dataset) or dataset.layout.rate == rate:
        return dataset
    old = dataset.layout.rate
    check_rates(old, rate)
    ahead = 1e3 * lookahead(old, rate)
    note = (
        f"Resampled from {old:g} Hz to {rate:g} Hz with a minimum-phase low-pass "
        f"that looks ahead {ahead:.2f} ms."
    )
    pinches = tuple(_resample_pinch(p, rate) for p in dataset.pinches)
    recorded = dataset.recorded_rate or old
    notes = (*dataset.notes, note)
    return replace(dataset, pinches=pinches, notes=notes, recorded_rate=recorded)
