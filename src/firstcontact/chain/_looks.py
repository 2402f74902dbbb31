"""The chain's arithmetic for looks of a logistic detector, for its training."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain._extension import chain_extension

Array = NDArray[Any]
#: Order of the linear prediction of a motor's noise, and number of features of a look.
ORDER, FEATURES = 12, 16


def fit_predictions(quiet: Array) -> NDArray[np.float64]:
    """Return filters that remove the predictable part of a motor's noise.

    A filter is a linear prediction (Yule-Walker) from the steady state. Motor spectra and ringing
    sensors differ between rigs, but the prediction error is white on all of them.

    Parameters
    ----------
    quiet
        Steady states in their sigmas, shape (n, samples), with 25 samples or more.

    Returns
    -------
    ndarray
        Weights of the newest sample and of the 12 samples before it, shape (n, 13). With them, the
        prediction error of each row of ``quiet`` has a sigma of 1. All are 0 for a constant row.
    """
    rows = np.ascontiguousarray(quiet, np.float64)
    out = np.empty((len(rows), ORDER + 1))
    chain_extension().fit_predictions(rows, rows.shape[1], out)
    return out


def look_features(
    looks: Array, weights: Array, lengths: Sequence[int], floor: float
) -> NDArray[np.float64]:
    """Return the loudness features of looks: of the signal, then of its prediction error.

    Each of the two has the same 8 features, all logarithms. The first is the level of the quiet
    part. The next are the levels of five spans at the end of the look, relative to the quiet part.
    Then comes the level between the longest of them and the quiet part, relative to the quiet
    part. The last is the peak in the longest span, relative to the peak in the quiet part.

    Parameters
    ----------
    looks
        Signals in sigmas of the steady state, shape (n, samples).
    weights
        Weights of :func:`fit_predictions` for each look, shape (n, 13).
    lengths, floor
        See :class:`DetectorConstants`.

    Returns
    -------
    ndarray
        Shape (n, 16).
    """
    rows = np.ascontiguousarray(looks, np.float64)
    out = np.empty((len(rows), FEATURES))
    chain_extension().look_features(
        rows,
        rows.shape[1],
        np.ascontiguousarray(weights, np.float64),
        np.array(lengths, np.int32),
        floor,
        out,
    )
    return out
