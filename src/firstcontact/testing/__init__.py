"""What every registered thing must do, as functions for whoever writes one: plain asserts."""

from firstcontact.testing.detector import check_detector
from firstcontact.testing.estimator import check_estimator

__all__ = ["check_detector", "check_estimator"]
