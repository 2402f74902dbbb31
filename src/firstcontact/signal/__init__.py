"""Filters that carry their state, resampling, and windows after a contact."""

from firstcontact.signal._resample import lookahead, resample, resample_dataset
from firstcontact.signal._resample_stream import CausalResampler
from firstcontact.signal._savgol import SavitzkyGolay
from firstcontact.signal._smoothing import AsSent, ExponentialSmoothing
from firstcontact.signal.windowing import (
    Conditioner,
    ContactWindow,
    WindowStream,
    contact_windows,
    samples_in,
)

__all__ = [
    "AsSent",
    "CausalResampler",
    "Conditioner",
    "ContactWindow",
    "ExponentialSmoothing",
    "SavitzkyGolay",
    "WindowStream",
    "contact_windows",
    "lookahead",
    "resample",
    "resample_dataset",
    "samples_in",
]
