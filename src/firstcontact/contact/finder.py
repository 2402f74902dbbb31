"""Search for contacts in whole recordings, for a person to confirm."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from firstcontact.signal import samples_in

#: Fewest samples on each side, needed for a variance.
LEAST_LOUD = 3


def pick_onset(windows: NDArray[np.float64], search: int) -> NDArray[np.intp]:
    """Return the sample in each window that best separates a quiet part from a loud one.

    Windows have the shape (n, samples). Only the last ``search`` samples of a window are
    candidates.
    """
    n = windows.shape[1]
    first = max(LEAST_LOUD, n - search)
    counts, weights = _split_sizes(n, first)
    # Row 0 is the quiet side of each split, row 1 the loud side.
    means = np.empty((2, len(windows), counts.shape[2]))
    variances = np.empty_like(means)
    for out, x in ((means, windows), (variances, windows**2)):
        sums = np.cumsum(x, axis=1)
        out[0] = sums[:, first - 1 : n - LEAST_LOUD]
        np.subtract(sums[:, -1:], out[0], out=out[1])
        out /= counts
    variances -= means**2
    # A millionth of the steady variance keeps the logarithm of a flat part finite.
    np.maximum(variances, 1e-6, out=variances)
    aic = (weights * np.log(variances)).sum(axis=0)
    picked: NDArray[np.intp] = first + np.argmin(aic, axis=1)
    return picked


@lru_cache(maxsize=64)
def _split_sizes(n: int, first: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the sizes of the two parts into which ``n`` samples can be split, and weights.

    The first part has ``first`` samples in the first split, and one more in each later split. The
    weights are those of the parts' log variances. Both arrays have the shape (2, 1, splits).
    """
    left = np.arange(first, n - LEAST_LOUD + 1, dtype=np.float64)
    counts = np.stack([left, n - left])[:, None]
    weights = np.stack([left, n - left - 1])[:, None]
    return counts, weights


#: Lengths of the spans after and before an onset that are compared, s. The span before is one
#: period of 50 Hz hum.
AHEAD, BEHIND = 0.003, 0.020
#: Shortest time between contacts of one sensor, s. Ringing and rebounds are shorter.
APART = 0.050
#: Least loudness of a contact relative to the signal's quiet level, and to the signal right before.
ABOVE_QUIET, ABOVE_BEFORE = 8.0, 3.0
#: A change is the difference between two samples CHANGE apart, s. At a contact, which is abrupt,
#: changes grow at least by the factor ABRUPT. A finger that swings back moves the signal as far,
#: but slowly: such a swing looks like a parabola, whose changes grow by a factor of 2.
CHANGE, ABRUPT = 0.001, 2.5
#: The onset is searched from EARLIER before a leap in loudness to LATER after it, s.
EARLIER, LATER = 0.012, 0.004
#: The quiet level is this quantile of the signal's levels in pieces of this length, s. Constant
#: pieces are digital silence (a noise gate, lost samples) and do not count.
QUIET_SHARE, PIECE = 0.2, 0.010


@dataclass(frozen=True, slots=True)
class Onset:
    """Contact that was found in a recording, for a person to confirm.

    ``column`` is the channel, and ``loudness`` the level after the contact relative to the quiet
    level.
    """

    column: int
    sample: int
    loudness: float


def find_onsets(signals: NDArray[np.float64], rate: float) -> list[Onset]:
    """Return all contacts in whole signals, shape (samples, channels), in time order."""
    onsets = []
    for column in range(signals.shape[1]):
        onsets += [Onset(column, *onset) for onset in _find_in_channel(signals[:, column], rate)]
    return sorted(onsets, key=lambda onset: (onset.sample, onset.column))


def _find_in_channel(signal: NDArray[np.float64], rate: float) -> list[tuple[int, float]]:
    """Return a pair for each contact in one channel, in time order: sample and loudness.

    The loudness is the level after the contact, relative to the quiet level.
    """
    ahead, behind, apart, lag = (
        max(1, samples_in(span, rate)) for span in (AHEAD, BEHIND, APART, CHANGE)
    )
    if len(signal) < ahead + behind:
        return []
    piece = max(2, samples_in(PIECE, rate))
    quiet = _noise_level(signal, piece)
    if not quiet > 0.0:
        return []
    places = np.arange(behind, len(signal) - ahead + 1)
    level_before, level_after = _rms_around(signal, places, ahead, behind)
    leap = level_after / np.maximum(level_before, quiet)
    change = signal - np.concatenate([signal[:1].repeat(lag), signal[:-lag]])
    steady, sudden = _rms_around(change, places, ahead, behind)
    steady = np.maximum(steady, _noise_level(change, piece))
    is_candidate = (
        (level_after > ABOVE_QUIET * quiet) & (leap > ABOVE_BEFORE) & (sudden > ABRUPT * steady)
    )
    out: list[tuple[int, float]] = []
    # The largest leap comes first. Smaller leaps near it belong to the same contact.
    order = np.flatnonzero(is_candidate)
    order = order[np.argsort(-leap[order], kind="stable")]
    free = np.ones(len(leap), np.bool_)
    for k in order:
        if free[k]:
            free[max(0, k - apart) : k + apart] = False
            out.append((_refine_onset(signal, int(places[k]), rate), float(level_after[k] / quiet)))
    return sorted(out)


def _rms_around(
    signal: NDArray[np.float64], places: NDArray[np.intp], ahead: int, behind: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the RMS of a signal before and after each sample in ``places``, as two arrays.

    ``behind`` is the number of samples before it, ``ahead`` the number from it on. The mean before
    it is subtracted from both.
    """
    x = signal - signal.mean()
    sums, power = (np.concatenate([[0.0], np.cumsum(v)]) for v in (x, x**2))
    mean = (sums[places] - sums[places - behind]) / behind
    level_before = (power[places] - power[places - behind]) / behind - mean**2
    mean_after = (sums[places + ahead] - sums[places]) / ahead
    level_after = (power[places + ahead] - power[places]) / ahead - 2 * mean_after * mean + mean**2
    return np.sqrt(np.maximum(level_before, 0.0)), np.sqrt(np.maximum(level_after, 0.0))


def _refine_onset(x: NDArray[np.float64], place: int, rate: float) -> int:
    """Return the sample at which a contact starts, near the sample ``place`` where it is louder.

    It is the sample that best separates a quiet part from a loud one.
    """
    earlier, later = samples_in(EARLIER, rate), samples_in(LATER, rate)
    start, stop = max(0, place - earlier), min(len(x), place + later)
    if stop - start < 2 * LEAST_LOUD:
        return place
    window = x[None, start:stop] - x[start:place].mean()
    scale = np.abs(window).max()
    return start + int(pick_onset(window / scale, stop - start)[0]) if scale > 0.0 else place


def _noise_level(x: NDArray[np.float64], piece: int) -> float:
    """Return the noise level of a signal: a low quantile of standard deviations of its pieces.

    ``piece`` is the number of samples in a piece. Constant pieces are not used.
    """
    pieces = x[: len(x) // piece * piece].reshape(-1, piece)
    pieces = pieces[np.ptp(pieces, axis=1) > 0]
    return float(np.quantile(pieces.std(axis=1), QUIET_SHARE)) if len(pieces) else 0.0
