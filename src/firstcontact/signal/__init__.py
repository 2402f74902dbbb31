"""Filters that carry their state, resampling, and windows after a contact."""

from firstcontact.signal.moving_average import MovingAverage
from firstcontact.signal.resample import resample, resample_dataset
from firstcontact.signal.savgol import SavitzkyGolay
from firstcontact.signal.smoothing import ExponentialSmoothing
from firstcontact.signal.windowing import (
    Conditioner,
    ContactWindow,
    WindowStream,
    contact_windows,
    samples_in,
)

__all__ = [
    "Conditioner",
    "ContactWindow",
    "ExponentialSmoothing",
    "MovingAverage",
    "SavitzkyGolay",
    "WindowStream",
    "contact_windows",
    "resample",
    "resample_dataset",
    "samples_in",
]
