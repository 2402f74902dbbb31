"""To another sampling rate, explicitly and on record."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.errors import InputError
from firstcontact.core.layout import ChannelKind
from firstcontact.core.pinch import Contact, Dataset, Pinch

#: Half of the anti-aliasing filter, in samples of the lower of the two rates.
HALF_LENGTH = 10
#: Largest denominator of the ratio of the rates. Usual rates are met within 2 ppm and any up to
#: 1 MHz within 250 ppm, 0.08 ms in a pinch of 0.3 s; a larger one makes the filter too long to run.
LARGEST_RATIO = 2000
#: Most samples that are made of one: what is between them nobody measured, and memory is bounded.
MOST_OF_ONE = 10


def lookahead(old: float, new: float) -> float:
    """Time that :func:`resample` looks ahead, s; 0 where the rates are the same."""
    return 0.0 if old == new else HALF_LENGTH / min(old, new)


def _ratio(old: float, new: float) -> Fraction:
    return Fraction(new / old).limit_denominator(LARGEST_RATIO)


def _position(position: int, ratio: Fraction) -> int:
    return round(position * ratio)


def resample(x: NDArray[Any], old: float, new: float) -> NDArray[np.float64]:
    """Polyphase resampling with a zero-phase low-pass (Kaiser, beta 5).

    Parameters
    ----------
    x
        Shape (samples, channels).
    old, new
        Rates, Hz.

    Returns
    -------
    ndarray
        Shape (about samples x new / old, channels). The filter looks ahead
        ten samples of the lower rate.
    """
    from scipy.signal import resample_poly

    ratio = _ratio(old, new)
    out: NDArray[np.float64] = resample_poly(
        np.asarray(x, dtype=np.float64), ratio.numerator, ratio.denominator, axis=0, padtype="edge"
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
        A rate more than ten times as high.
    """
    if not len(dataset) or dataset.layout.rate == rate:
        return dataset
    old = dataset.layout.rate
    if rate > MOST_OF_ONE * old:
        raise InputError(
            f"samples at {old:g} Hz cannot stand for ones at {rate:g} Hz, more than "
            f"{MOST_OF_ONE} times as many: train a model at their rate"
        )
    ahead = 1e3 * lookahead(old, rate)
    note = (
        f"Resampled from {old:g} Hz to {rate:g} Hz with a zero-phase low-pass "
        f"that looks ahead {ahead:.1f} ms."
    )
    pinches = tuple(_resample_pinch(p, rate) for p in dataset.pinches)
    recorded = dataset.recorded_rate or old
    notes = (*dataset.notes, note)
    return replace(dataset, pinches=pinches, notes=notes, recorded_rate=recorded)
