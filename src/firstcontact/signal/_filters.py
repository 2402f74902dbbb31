"""Smoothing filters that keep their state between blocks."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ChannelKind, Layout
from firstcontact.core.layout import FINGERTIP_SMOOTHING

#: Length and order of the Savitzky–Golay filter. Five points look ahead only two samples (0.4 ms at
#: 4936 Hz) and remove half of the white noise power. Their -3 dB point is near 1.2 kHz, above the
#: 570 Hz of the smoothing on the microcontroller, so they keep its signal.
SAVGOL_LENGTH = 5
SAVGOL_ORDER = 2


class ExponentialSmoothing:
    """Streaming first-order low-pass filter, ``y[n] = y[n-1] + alpha (x[n] - y[n-1])``.

    The first output equals the first input, so a constant signal stays unchanged.

    Parameters
    ----------
    alpha
        Weight of the newest sample, 0 < alpha <= 1 (1 changes nothing).
    mask
        Boolean mask, True for channels to filter, shape (channels,). By default all are filtered.

    Raises
    ------
    ValueError
        ``alpha`` is outside (0, 1].

    Examples
    --------
    >>> import numpy as np
    >>> ExponentialSmoothing(0.5).update(np.array([[0.0], [1.0], [1.0]]))[:, 0].tolist()
    [0.0, 0.5, 0.75]
    """

    def __init__(
        self, alpha: float = FINGERTIP_SMOOTHING, mask: NDArray[np.bool_] | None = None
    ) -> None:
        if not 0.0 < alpha <= 1.0:
            raise ValueError(f"alpha is {alpha}: give a number above 0 and at most 1")
        self.alpha = alpha
        self.mask = mask
        self._state: NDArray[np.float64] | None = None

    def update(self, x: NDArray[Any]) -> NDArray[np.float64]:
        """Filter the next samples, shape (n, channels). The sizes of the blocks do not matter."""
        # scipy.signal takes 0.3 s to import, so the import waits until the first use.
        from scipy.signal import lfilter

        samples = np.asarray(x, dtype=np.float64)
        if len(samples) == 0:
            return samples.copy()
        keep = 1.0 - self.alpha
        state = keep * samples[:1] if self._state is None else self._state
        y, self._state = lfilter([self.alpha], [1.0, -keep], samples, axis=0, zi=state)
        out: NDArray[np.float64] = y if self.mask is None else np.where(self.mask, y, samples)
        return out


class DeviceSmoothing:
    """Streaming filter for vibration channels, with the smoothing of the published hand's firmware.

    Channels that the device has smoothed already stay unchanged.

    Parameters
    ----------
    layout
        Layout of the samples. It states which channels the device has smoothed.
    columns
        Column numbers, in the layout, of the data's columns. By default, all vibration channels.
    """

    def __init__(self, layout: Layout, columns: tuple[int, ...] | None = None) -> None:
        channels = layout.column_channels
        chosen = layout.columns(ChannelKind.VIBRATION) if columns is None else columns
        raw = np.array([channels[c].smoothing_alpha == 1.0 for c in chosen], dtype=np.bool_)
        self._smoothing = None
        if raw.any():
            mask = None if raw.all() else raw
            self._smoothing = ExponentialSmoothing(FINGERTIP_SMOOTHING, mask)

    def update(self, volts: NDArray[Any]) -> NDArray[Any]:
        """Smooth the next samples. Input and output have the shape (n, channels)."""
        return volts if self._smoothing is None else self._smoothing.update(volts)


@lru_cache(maxsize=1)
def _savgol_weights() -> NDArray[np.float64]:
    """Return the weights of the centred Savitzky-Golay filter, shape (length,)."""
    half = SAVGOL_LENGTH // 2
    times = np.arange(-half, half + 1, dtype=np.float64)
    powers = np.vander(times, SAVGOL_ORDER + 1, increasing=True)
    weights: NDArray[np.float64] = np.linalg.pinv(powers)[0]
    return (weights + weights[::-1]) / 2.0


class SavitzkyGolay:
    """Centred Savitzky–Golay filter for streams, whose outputs wait for later samples.

    Output i is the smoothed input i, and is returned with input ``i + lookahead``. The first input
    is repeated as padding before the stream. The end is not padded: the last ``lookahead`` inputs
    have no output. Results for recordings therefore equal live results.

    Attributes
    ----------
    lookahead
        Number of later samples that an output needs.
    """

    lookahead = SAVGOL_LENGTH // 2

    def __init__(self) -> None:
        self._weights = _savgol_weights()
        self._past: NDArray[np.float64] | None = None

    def update(self, x: NDArray[Any]) -> NDArray[np.float64]:
        """Filter the next samples, shape (n, channels).

        Returns
        -------
        ndarray
            Outputs that can be computed now, shape (m, channels). How the stream is cut into calls
            does not change their values.
        """
        samples = np.asarray(x, dtype=np.float64)
        if len(samples) == 0:
            return samples.copy()
        if self._past is None:
            self._past = np.repeat(samples[:1], self.lookahead, axis=0)
        extended = np.concatenate([self._past, samples])
        n = max(0, len(extended) - SAVGOL_LENGTH + 1)
        out = np.zeros((n, samples.shape[1]))
        for k, weight in enumerate(self._weights):
            out += weight * extended[k : k + n]
        self._past = extended[n:].copy()
        return out
