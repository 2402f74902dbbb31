"""Collecting: guided recording, calibration, and the page on which contacts are labelled."""

from .calibration import calibrate as calibrate
from .session import record as record
