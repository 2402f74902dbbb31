"""Filters that carry their state, resampling, and windows after a contact."""

from ._closing_speed import closing_speed as closing_speed
from ._filters import DeviceSmoothing as DeviceSmoothing
from ._filters import ExponentialSmoothing as ExponentialSmoothing
from ._filters import SavitzkyGolay as SavitzkyGolay
from .resampling import CausalResampler as CausalResampler
from .resampling import resample as resample
from .resampling import resample_dataset as resample_dataset
from .windowing import contact_windows as contact_windows
from .windowing import samples_in as samples_in
