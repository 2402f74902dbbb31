"""Resampling of recordings and streams to another sampling rate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ChannelKind, Contact, Dataset, ModelError, Pinch

#: Half length of the anti-aliasing filter, in samples of the lower rate.
HALF_LENGTH = 10
#: Shape parameter of the filter's Kaiser window.
BETA = 5.0
#: Number of points per tap in the spectrum from which the minimum phase is computed.
FINE = 16
#: Largest denominator of the ratio of the rates. The ratio is then exact within 2 ppm for usual
#: rates, and within 250 ppm for any rate up to 1 MHz: 0.08 ms in a pinch of 0.3 s. A larger
#: denominator makes the filter too long.
LARGEST_RATIO = 2000
#: Largest relative error of the ratio.
FARTHEST_OFF = 0.001
#: Largest factor of upsampling. It bounds the memory, and interpolated samples add no information.
MOST_OF_ONE = 10
#: Longest look-ahead of the filter, s.
LONGEST_AHEAD = 0.0005


def lookahead(old: float, new: float) -> float:
    """Return the time by which :func:`resample` looks ahead, s, from ``old`` to ``new`` Hz.

    It is 0 for equal rates.
    """
    if old == new:
        return 0.0
    ratio = _ratio(old, new)
    return _anti_alias_filter(ratio, old)[1] / (ratio.numerator * old)


def check_rates(old: float, new: float) -> None:
    """Raise ModelError if samples at ``old`` Hz cannot be resampled to ``new`` Hz."""
    if new > MOST_OF_ONE * old:
        raise ModelError(
            f"samples at {old:g} Hz cannot be resampled to {new:g} Hz, which is more than "
            f"{MOST_OF_ONE} times their rate: train a model at {old:g} Hz"
        )
    if abs(_ratio(old, new) * old / new - 1) > FARTHEST_OFF:
        raise ModelError(
            f"samples at {old:g} Hz cannot be resampled to {new:g} Hz, because the rates differ "
            "too much: set the device to a lower rate, or train a model at its rate"
        )


def _ratio(old: float, new: float) -> Fraction:
    return Fraction(new / old).limit_denominator(LARGEST_RATIO)


@lru_cache(maxsize=16)
def _anti_alias_filter(ratio: Fraction, old: float) -> tuple[NDArray[np.float64], int]:
    """Return the coefficients of the filter against aliasing, and the filter's look-ahead.

    ``old`` is the old rate, Hz, and ``ratio`` the new rate divided by it. There is one coefficient
    per sample of the common rate, ``ratio.numerator * old``. The look-ahead is in such samples.
    """
    from scipy.signal import firwin, minimum_phase

    if ratio == 1:  # for example 4936 Hz and a clock that is slightly off
        return np.ones(1), 0
    slower = max(ratio.numerator, ratio.denominator)
    symmetric = firwin(2 * HALF_LENGTH * slower + 1, 1 / slower, window=("kaiser", BETA))
    points = 2 ** int(np.ceil(np.log2(FINE * len(symmetric))))
    taps = minimum_phase(symmetric, n_fft=points, half=False)
    taps /= taps.sum()
    lag = round(float(np.arange(len(taps)) @ taps))
    return taps, min(lag, int(LONGEST_AHEAD * ratio.numerator * old))


@dataclass(frozen=True, slots=True)
class _Numbering:
    """Conversion of sample numbers to another rate.

    The sample ``start`` gets the number ``new_start``. Later numbers grow by the factor ``ratio``.
    """

    start: int
    new_start: int
    ratio: Fraction

    @classmethod
    def of(cls, pinch: Pinch, rate: float) -> Self:
        """Return the conversion for a pinch that is resampled to ``rate``, Hz."""
        ratio = _ratio(pinch.layout.rate, rate)
        return cls(pinch.first_sample, round(pinch.first_sample * ratio), ratio)

    @property
    def inverse(self) -> _Numbering:
        return _Numbering(self.new_start, self.start, 1 / self.ratio)

    def sample(self, number: int) -> int:
        # Counted from the pinch's start, where the error of the ratio stays below one sample.
        return self.new_start + round((int(number) - self.start) * self.ratio)

    def contact(self, contact: Contact) -> Contact:
        return Contact(contact.finger, self.sample(contact.sample), self.sample(contact.decided))


def resample(x: NDArray[Any], old: float, new: float) -> NDArray[np.float64]:
    """Resample signals with a polyphase, minimum-phase low-pass filter.

    Let f be the lower one of ``old`` and ``new``. The gain is 0.5 at 0.5 f, 0.08 at 0.55 f, and at
    most 0.003 (-50 dB) above 0.6 f. An output sample depends on input samples up to
    :func:`lookahead` later. The look-ahead is 1.8 / f, but at most 0.5 ms. If 1.8 / f is longer
    than 0.5 ms (f below 3.6 kHz), the filter delays the signal by the difference.

    Parameters
    ----------
    x
        Samples, shape (samples, channels).
    old, new
        Sampling rates of input and output, Hz.

    Returns
    -------
    ndarray
        Resampled signals, shape (about samples x new / old, channels).
    """
    from scipy.signal import resample_poly

    ratio = _ratio(old, new)
    taps, ahead = _anti_alias_filter(ratio, old)
    # SciPy treats the middle of a filter as the present. Zeros move the present there.
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


def _resample_pinch(pinch: Pinch, rate: float) -> Pinch:
    layout = pinch.layout
    new = _Numbering.of(pinch, rate)
    data = resample(pinch.data, layout.rate, rate).astype(np.float32)
    strips = list(layout.columns(ChannelKind.STRIP))
    if strips:
        # A strip is open or closed, so interpolation makes no sense.
        nearest = np.rint(np.arange(len(data)) / float(new.ratio)).astype(np.intp)
        data[:, strips] = pinch.data[np.minimum(nearest, len(pinch.data) - 1)][:, strips]
    return replace(
        pinch,
        data=data,
        layout=replace(layout, rate=rate),
        first_sample=new.new_start,
        truth=tuple(new.contact(contact) for contact in pinch.truth),
        motor_start=None if pinch.motor_start is None else new.sample(pinch.motor_start),
    )


def resample_dataset(dataset: Dataset, rate: float) -> Dataset:
    """Resample all pinches, convert the sample numbers of contacts, and extend ``notes``.

    A dataset that already has this rate is returned unchanged. Samples become float32 in the raw
    unit of the layout, so its scale and offset stay valid. Contact strips, which are 0 or 1, are
    not interpolated: they have the value of the nearest old sample.

    Parameters
    ----------
    dataset
        The pinches.
    rate
        New sampling rate, Hz.

    Raises
    ------
    InputError
        The new rate is more than ten times the old one, or too low for the filter.
    """
    if not len(dataset) or dataset.layout.rate == rate:
        return dataset
    old = dataset.layout.rate
    check_rates(old, rate)
    lookahead_ms = 1e3 * lookahead(old, rate)
    note = (
        f"Resampled from {old:g} Hz to {rate:g} Hz with a minimum-phase low-pass "
        f"that looks ahead {lookahead_ms:.2f} ms."
    )
    pinches = tuple(_resample_pinch(p, rate) for p in dataset.pinches)
    recorded = dataset.recorded_rate or old
    notes = (*dataset.notes, note)
    return replace(dataset, pinches=pinches, notes=notes, recorded_rate=recorded)


def resample_contacts(
    contacts: Sequence[Contact | None], dataset: Dataset, rate: float
) -> list[Contact | None]:
    """Convert sample numbers of contacts to a new rate, Hz, as :func:`resample_dataset` does.

    ``contacts`` has one contact per pinch of ``dataset``, or None.
    """
    pairs = zip(contacts, dataset.pinches, strict=True)
    return [c and _Numbering.of(pinch, rate).contact(c) for c, pinch in pairs]


def restore_contacts(
    contacts: Sequence[Contact | None], dataset: Dataset, rate: float
) -> list[Contact | None]:
    """Convert contacts from :func:`resample_contacts` back to sample numbers of ``dataset``."""
    out: list[Contact | None] = []
    for contact, pinch in zip(contacts, dataset.pinches, strict=True):
        if contact is not None:
            contact = _Numbering.of(pinch, rate).inverse.contact(contact)
            last = pinch.first_sample + len(pinch.data) - 1  # rounding may exceed it
            contact = Contact(contact.finger, min(contact.sample, last), min(contact.decided, last))
        out.append(contact)
    return out


class CausalResampler:
    """Streaming resampler with the same output as :func:`firstcontact.signal.resample`.

    Output sample ``k`` has the time of input sample ``k * old / new``. Missing input samples are
    not filled in. After such a gap, the filter restarts as if the signal before had been constant.

    Parameters
    ----------
    old, new
        Sampling rates of input and output, Hz.
    nearest_columns
        Columns, such as contact strips, that are not interpolated: an output has the value of the
        nearest input.
    origin
        Number of an input sample that coincides with an output sample, as the first sample of a
        pinch does in :func:`resample_dataset`.

    Attributes
    ----------
    delay
        Delay of the output, s: an output sample needs input samples up to this much later. At most
        0.5 ms.
    """

    def __init__(
        self, old: float, new: float, nearest_columns: Sequence[int] = (), origin: int = 0
    ) -> None:
        ratio = _ratio(old, new)
        self._origin, self._new_origin = origin, round(origin * ratio)
        self._nearest = list(nearest_columns)
        self._up, self._down = ratio.numerator, ratio.denominator
        taps, self._ahead = _anti_alias_filter(ratio, old)
        self.delay = self._ahead / (self._up * old)
        length = -(-len(taps) // self._up)
        padded = np.zeros(length * self._up)
        padded[: len(taps)] = taps * self._up
        # One row of taps per position between two input samples, oldest sample first.
        self._taps = np.ascontiguousarray(padded.reshape(length, self._up).T[:, ::-1])
        self._past: NDArray[np.float64] | None = None
        self._end = 0  # number of the next input sample
        self._next = 0  # number of the next output sample

    def number(self, sample: int) -> int:
        """Return the number of the output sample nearest in time to the input sample ``sample``."""
        since = sample - self._origin
        return self._new_origin + (2 * since * self._up + self._down) // (2 * self._down)

    def update(self, x: NDArray[np.floating], first: int) -> tuple[NDArray[np.float64], int]:
        """Resample the next samples.

        Parameters
        ----------
        x
            Input samples, shape (samples, channels).
        first
            Number of the input sample ``x[0]``. It must be above those of all earlier samples.

        Returns
        -------
        tuple
            Output samples, shape (samples, channels), and the number of the first of them.
        """
        if not len(x):
            return np.zeros(x.shape), self._next + self._new_origin
        first -= self._origin
        history = self._taps.shape[1] - 1
        if self._past is None or first != self._end:
            self._past = np.repeat(np.asarray(x[:1], np.float64), history, axis=0)
            # First output whose instant is not before this sample.
            self._next = -(-first * self._up // self._down)
        samples = np.concatenate([self._past, x])
        origin = first - history  # number of samples[0]
        self._end = first + len(x)
        # Output k needs inputs up to (k down + ahead) / up, which must be below the end.
        stop = max(-(-(self._end * self._up - self._ahead) // self._down), self._next)
        places = np.arange(self._next, stop) * self._down + self._ahead
        newest, phases = places // self._up, places % self._up
        rows = (newest - history - origin)[:, None] + np.arange(history + 1)
        out = np.einsum("kt,ktc->kc", self._taps[phases], samples[rows])
        if self._nearest:
            # Numbers of the input samples nearest to these instants.
            centres = 2 * np.arange(self._next, stop) * self._down
            nearest = np.minimum((centres + self._up) // (2 * self._up), self._end - 1) - origin
            out[:, self._nearest] = samples[nearest][:, self._nearest]
        self._past = samples[len(samples) - history :] if history else samples[:0]
        first_output, self._next = self._next, stop
        return out, first_output + self._new_origin
