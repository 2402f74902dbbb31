"""Where contacts began in a finished recording: looks ahead and back, for labelling."""

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
    every sample, and takes the largest leaps first. So it finds more and cannot run live. The
    signal is not filtered: forwards, that would delay a contact, and in both directions a slow
    one would begin before it began.

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
    ahead, behind, apart = (samples_in(span, rate) for span in (AHEAD, BEHIND, APART))
    if len(signal) < ahead + behind:
        return []
    quiet = _quiet(signal, samples_in(PIECE, rate))
    if not quiet > 0.0:
        return []
    x = signal - signal.mean()
    sums, power = (np.concatenate([[0.0], np.cumsum(v)]) for v in (x, x**2))
    places = np.arange(behind, len(x) - ahead + 1)
    before = (sums[places] - sums[places - behind]) / behind
    was = np.sqrt(np.maximum((power[places] - power[places - behind]) / behind - before**2, 0.0))
    # Around the mean of what was: a sensor that drifts makes no contact.
    its = (sums[places + ahead] - sums[places]) / ahead
    comes = (power[places + ahead] - power[places]) / ahead - 2 * its * before + before**2
    comes = np.sqrt(np.maximum(comes, 0.0))
    leap = comes / np.maximum(was, quiet)
    able = (comes > ABOVE_QUIET * quiet) & (leap > ABOVE_BEFORE)
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
