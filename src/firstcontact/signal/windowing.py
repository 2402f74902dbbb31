"""Windows of signal after a contact, the input of the window models.

The baseline of a window is the mean of the signal shortly before its contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ChannelKind, Contact, Dataset, Layout
from firstcontact.signal._filters import DeviceSmoothing, SavitzkyGolay

#: Longest quiet part before the contact whose mean (the quiet level) is subtracted, s.
BASELINE = 0.020
#: Time between this quiet part and the contact, s, because a detector may be a little late.
BASELINE_GUARD = 0.002
#: Shortest quiet part, s. Windows with less quiet are refused.
BASELINE_LEAST = 0.002


def samples_in(duration: float, rate: float) -> int:
    """Return the number of samples in a duration, s, rounded: 0.015 s at 4936 Hz give 74."""
    return round(duration * rate)


class Conditioner:
    """Streaming filter for window models: the device's smoothing, then a Savitzky-Golay filter.

    Channels that the device has smoothed already are not smoothed again. ``columns`` are the column
    numbers of the data, by default those of all vibration channels.
    """

    lookahead = SavitzkyGolay.lookahead

    def __init__(self, layout: Layout, columns: tuple[int, ...] | None = None) -> None:
        self._smoothing = DeviceSmoothing(layout, columns)
        self._savgol = SavitzkyGolay()

    def update(self, volts: NDArray[Any]) -> NDArray[np.float64]:
        """Filter the next samples, shape (n, channels).

        Return the outputs that can be computed now, shape (m, channels).
        """
        return self._savgol.update(self._smoothing.update(volts))


def cut_window(
    conditioned: NDArray[np.float64], start: int, length: int, rate: float
) -> NDArray[np.float32] | None:
    """Cut a window from a filtered signal, and subtract the mean of the signal before it.

    ``conditioned`` is one channel, shape (samples,). The window has ``length`` samples from
    ``start``, shape (length, 1). Return None if the signal is too short, constant or not finite.
    """
    quiet_end = start - samples_in(BASELINE_GUARD, rate)
    quiet_start = max(0, quiet_end - samples_in(BASELINE, rate))
    if quiet_end - quiet_start < max(1, samples_in(BASELINE_LEAST, rate)):
        return None
    if start + length > len(conditioned):
        return None
    window = conditioned[start : start + length] - conditioned[quiet_start:quiet_end].mean()
    if not np.isfinite(window).all() or np.ptp(window) == 0.0:
        return None
    out: NDArray[np.float32] = window.astype(np.float32)[:, None]
    return out


def contact_windows(
    dataset: Dataset,
    contacts: Sequence[Contact | None],
    duration: float,
    *,
    conditioned: bool = True,
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Cut a window of signal after each contact, one per pinch. Window models use them as input.

    Parameters
    ----------
    dataset
        The pinches.
    contacts
        Contact of each pinch, at which its window starts; None for a pinch without contact.
    duration
        Length of the windows, s.
    conditioned
        True to smooth the signal first, as the package's window models need it; False to use it
        as the device sent it.

    Returns
    -------
    windows : ndarray
        Vibration of the contact's finger minus its mean before the contact, in the channel's unit
        (V for piezos), shape (pinches with a window, samples, 1).
    kept : ndarray
        Boolean mask of the pinches with a window, shape (pinches,). A window needs a contact and a
        sensor on that finger. The pinch must contain the window, the look-ahead of the filter, and
        at least 2 ms of signal that end 2 ms before the contact. The window must be finite and not
        constant.
    """
    has_window = np.zeros(len(dataset), dtype=np.bool_)
    windows: list[NDArray[np.float32]] = []
    length = 0
    for i, (pinch, contact) in enumerate(zip(dataset.pinches, contacts, strict=True)):
        length = samples_in(duration, pinch.layout.rate)
        if contact is None:
            continue
        columns = pinch.layout.columns(ChannelKind.VIBRATION, contact.finger)
        if not columns:
            continue
        volts = pinch.layout.physical(pinch.data, columns)
        signal = Conditioner(pinch.layout, columns).update(volts) if conditioned else volts
        window = cut_window(
            signal[:, 0], contact.sample - pinch.first_sample, length, pinch.layout.rate
        )
        if window is not None:
            has_window[i] = True
            windows.append(window)
    if not windows:
        return np.zeros((0, length, 1), dtype=np.float32), has_window
    return np.stack(windows), has_window
