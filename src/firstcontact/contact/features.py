"""What the SVM sees of a window."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

#: Parts that the old and the new side of a window are summed up in.
OLD_PARTS = 3
NEW_PARTS = 3
#: Added to an rms, in sigmas, before its logarithm: below it nothing matters.
FLOOR = 0.1


def _log_rms(x: NDArray[np.float64], edges: NDArray[np.intp]) -> NDArray[np.float64]:
    """Logarithm of the rms between neighbouring edges, shape (windows, parts)."""
    squares = np.concatenate([np.zeros((len(x), 1)), np.cumsum(x**2, axis=1)], axis=1)
    power = np.diff(squares[:, edges], axis=1) / np.diff(edges)
    out: NDArray[np.float64] = np.log(np.sqrt(np.maximum(power, 0.0)) + FLOOR)
    return out


def window_features(windows: NDArray[np.float64], step: int) -> NDArray[np.float64]:
    """Shape of the new part, and how loud each part is.

    The new samples about the mean of the old ones, compressed by asinh so that
    a loud contact and a faint one lie close together; the logarithmic rms of
    three old and of three new parts, of the signal and of its differences
    (short clicks and slow contacts differ in their ratio); and how far the new
    peaks exceed the old ones.

    Parameters
    ----------
    windows
        Shape (windows, samples), in sigmas of the steady state.
    step
        Samples in the new part.

    Returns
    -------
    ndarray
        Shape (windows, step + 14).
    """
    n = windows.shape[1]
    old = n - step
    centred = windows - windows[:, :old].mean(axis=1, keepdims=True)
    slope = np.diff(centred, axis=1, prepend=centred[:, :1])
    edges = np.concatenate(
        [
            np.linspace(0, old, OLD_PARTS + 1).astype(np.intp),
            np.linspace(old, n, NEW_PARTS + 1).astype(np.intp)[1:],
        ]
    )
    peaks = [
        np.log(np.abs(x[:, old:]).max(axis=1) + FLOOR)
        - np.log(np.abs(x[:, :old]).max(axis=1) + FLOOR)
        for x in (centred, slope)
    ]
    return np.concatenate(
        [
            np.arcsinh(centred[:, old:]),
            _log_rms(centred, edges),
            _log_rms(slope, edges),
            np.stack(peaks, axis=1),
        ],
        axis=1,
    )
