"""Exponential smoothing, as on the microcontroller."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FINGERTIP_SMOOTHING, ChannelKind, Layout


class ExponentialSmoothing:
    """First-order recursive low-pass, ``y[n] = y[n-1] + alpha (x[n] - y[n-1])``.

    The filter starts at its first sample, so a constant input stays unchanged.

    Parameters
    ----------
    alpha
        Weight of the newest sample, 0 < alpha <= 1 (1 changes nothing).
    mask
        Mask of the channels to filter, shape (channels,). The other channels stay unchanged.

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
        self,
        alpha: float = FINGERTIP_SMOOTHING,
        mask: NDArray[np.bool_] | None = None,
    ) -> None:
        if not 0.0 < alpha <= 1.0:
            raise ValueError(f"alpha is {alpha}; it must be above 0 and at most 1")
        self.alpha = alpha
        self.mask = mask
        self._state: NDArray[np.float64] | None = None

    def update(self, x: NDArray[Any]) -> NDArray[np.float64]:
        """Filter the next samples.

        Parameters
        ----------
        x
            Shape (n, channels).

        Returns
        -------
        ndarray
            Shape (n, channels). The result does not depend on the block sizes.
        """
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


def missing_smoothing(
    layout: Layout, columns: tuple[int, ...] | None = None
) -> ExponentialSmoothing | None:
    """Return the microcontroller's smoothing filter for the columns that are not smoothed yet."""
    channels = layout.column_channels
    chosen = layout.columns(ChannelKind.VIBRATION) if columns is None else columns
    raw = np.array([channels[c].smoothing_alpha == 1.0 for c in chosen], dtype=np.bool_)
    if not raw.any():
        return None
    return ExponentialSmoothing(FINGERTIP_SMOOTHING, None if raw.all() else raw)


class DeviceSmoothing:
    """Filter that smooths raw vibration as the device does. Smoothed channels stay unchanged.

    Parameters
    ----------
    layout
        Layout of the samples, with their smoothing.
    columns
        Column numbers, by default those of vibration.
    """

    def __init__(self, layout: Layout, columns: tuple[int, ...] | None = None) -> None:
        self._smoothing = missing_smoothing(layout, columns)

    def update(self, volts: NDArray[Any]) -> NDArray[Any]:
        """Smooth the next samples, shape (n, channels)."""
        return volts if self._smoothing is None else self._smoothing.update(volts)
