"""Filters that carry their state, resampling, and windows after a contact."""

from ._closing_speed import closing_speed as closing_speed
from ._filters import DeviceSmoothing as DeviceSmoothing
from ._filters import ExponentialSmoothing as ExponentialSmoothing
from ._filters import SavitzkyGolay as SavitzkyGolay
from ._resampling import CausalResampler as CausalResampler
from ._resampling import check_rates as check_rates
from ._resampling import lookahead as lookahead
from ._resampling import resample as resample
from ._resampling import resample_contacts as resample_contacts
from ._resampling import resample_dataset as resample_dataset
from ._resampling import restore_contacts as restore_contacts
from ._windowing import BASELINE as BASELINE
from ._windowing import BASELINE_GUARD as BASELINE_GUARD
from ._windowing import Conditioner as Conditioner
from ._windowing import ContactWindow as ContactWindow
from ._windowing import WindowStream as WindowStream
from ._windowing import contact_windows as contact_windows
from ._windowing import samples_in as samples_in
