"""Collecting: guided recording, calibration, and the page on which contacts are labelled."""

from ._record import record as record
from .calibration import calibrate as calibrate
