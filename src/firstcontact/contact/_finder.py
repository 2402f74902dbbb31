"""Offline onset finder for labelling: it looks ahead and back in a whole recording."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact._onset import pick_onset
from firstcontact.signal import samples_in

#: What comes is compared with what was before over these spans, s; the latter is a period of
#: 50 Hz hum.
AHEAD, BEHIND = 0.003, 0.020
#: Contacts of one sensor are at least so far apart, s: ringing and rebounds are no contacts.
APART = 0.050
#: A contact is so many times louder than the signal's quiet, and than what was right before it.
ABOVE_QUIET, ABOVE_BEFORE = 8.0, 3.0
#: A contact is abrupt: changes over this span, s, become so many times larger than right before.
#: A finger that swings back moves the signal as far, but slowly: a parabola, which any slow swing
#: is over the spans above, reaches 2.
CHANGE, ABRUPT = 0.001, 2.5
#: The onset is looked for so far around where the loudness leaps, s.
EARLIER, LATER = 0.012, 0.004
#: The quiet is the level that this share of the signal stays below, in pieces this long, s.
QUIET_SHARE, PIECE = 0.2, 0.010


@dataclass(frozen=True, slots=True)
class Onset:
    """A contact that was found.

    Parameters
    ----------
    column
        Number of its vibration channel.
    sample
        Where it began, from 0.
    loudness
        How many times louder than the signal's quiet.
    """

    column: int
    sample: int
    loudness: float


def find_onsets(signals: NDArray[np.float64], rate: float) -> list[Onset]:
    """All contacts in whole signals, in the order of time.

    Unlike a detector, it knows the quiet of the whole signal, compares what comes with what was at
    every sample, and takes the largest leaps first. So it finds more and cannot run live. A leap
    counts where the signal also changes faster than before, so slow swings are no contacts.
    Rebounds are. The onset is placed in the unfiltered signal: a causal filter would delay it,
    and a filter in both directions would begin a slow one too early.

    Parameters
    ----------
    signals
        Vibration channels, shape (samples, channels).
    rate
        Hz.
    """
    found = []
    for column in range(signals.shape[1]):
        found += [Onset(column, *each) for each in _of_channel(signals[:, column], rate)]
    return sorted(found, key=lambda onset: (onset.sample, onset.column))


def _of_channel(signal: NDArray[np.float64], rate: float) -> list[tuple[int, float]]:
    """Sample and loudness of each onset."""
    ahead, behind, apart, lag = (
        max(1, samples_in(span, rate)) for span in (AHEAD, BEHIND, APART, CHANGE)
    )
    if len(signal) < ahead + behind:
        return []
    quiet = _quiet(signal, samples_in(PIECE, rate))
    if not quiet > 0.0:
        return []
    places = np.arange(behind, len(signal) - ahead + 1)
    was, comes = _levels(signal, places, ahead, behind)
    leap = comes / np.maximum(was, quiet)
    change = signal - np.concatenate([signal[:1].repeat(lag), signal[:-lag]])
    steady, sudden = _levels(change, places, ahead, behind)
    steady = np.maximum(steady, _quiet(change, samples_in(PIECE, rate)))
    able = (comes > ABOVE_QUIET * quiet) & (leap > ABOVE_BEFORE) & (sudden > ABRUPT * steady)
    out: list[tuple[int, float]] = []
    # The largest leap first; what is near it is the same contact.
    order = np.flatnonzero(able)
    order = order[np.argsort(-leap[order], kind="stable")]
    free = np.ones(len(leap), np.bool_)
    for k in order:
        if free[k]:
            free[max(0, k - apart) : k + apart] = False
            out.append((_refined(signal, int(places[k]), rate), float(comes[k] / quiet)))
    return sorted(out)


def _levels(
    signal: NDArray[np.float64], places: NDArray[np.intp], ahead: int, behind: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Deviation before each place, and level after it around the mean before it.

    Around that mean, a sensor that drifts makes no contact.
    """
    x = signal - signal.mean()
    sums, power = (np.concatenate([[0.0], np.cumsum(v)]) for v in (x, x**2))
    mean = (sums[places] - sums[places - behind]) / behind
    was = (power[places] - power[places - behind]) / behind - mean**2
    after = (sums[places + ahead] - sums[places]) / ahead
    comes = (power[places + ahead] - power[places]) / ahead - 2 * after * mean + mean**2
    return np.sqrt(np.maximum(was, 0.0)), np.sqrt(np.maximum(comes, 0.0))


def _refined(x: NDArray[np.float64], place: int, rate: float) -> int:
    """The split around a leap that explains quiet and loud best."""
    earlier, later = samples_in(EARLIER, rate), samples_in(LATER, rate)
    start, stop = max(0, place - earlier), min(len(x), place + later)
    window = x[None, start:stop] - x[start:place].mean()
    scale = np.abs(window).max()
    return start + int(pick_onset(window / scale, stop - start)[0]) if scale > 0.0 else place


def _quiet(x: NDArray[np.float64], piece: int) -> float:
    """Level of the quieter pieces: their deviation."""
    pieces = x[: len(x) // piece * piece].reshape(-1, piece)
    return float(np.quantile(pieces.std(axis=1), QUIET_SHARE))
